"""The command that made a run folder, as its configuration tells it."""

import re
import shlex
from pathlib import Path

CONFIG_FILE = "config.yaml"


def command_of(folder: Path) -> str:
    """The command that made a run folder, which is the first line of its configuration; empty where none is told."""
    path = folder / CONFIG_FILE
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else []
    made = re.match(r"# (dr-lab \w+.*)", lines[0]) if lines else None
    return made[1] if made else ""


def config_dirs_of(folder: Path) -> list[str]:
    """The flags of that command that name configuration folders, as shell words."""
    words = shlex.split(command_of(folder))
    return [word for k, flag in enumerate(words) if flag == "--config-dir" for word in words[k : k + 2]]


def verb_of(folder: Path) -> str:
    """The verb that made a run folder; empty where none is told."""
    made = re.match(r"dr-lab (\w+)", command_of(folder))
    return made[1] if made else ""
