"""What a run was made with, and the file from which it can be made again."""

import platform
import shlex
import subprocess
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import yaml
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.folders import PACKAGE
from dr_lab.files import write_text
from dr_lab.run_command import CONFIG_FILE
from dr_lab.version import __version__

LIBRARIES = {"mujoco": "mujoco", "numpy": "numpy", "scipy": "scipy", "rerun": "rerun-sdk"}


def versions() -> dict[str, str]:
    """Versions of dr_lab, of Python and of the libraries that decide the numbers."""
    found = {"dr_lab": __version__, "python": platform.python_version()}
    for name, distribution in LIBRARIES.items():
        try:
            found[name] = version(distribution)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


def git_state() -> dict[str, Any] | None:
    """Commit of the checkout that dr_lab runs from, and whether tracked files differ from it; None outside of one."""
    if not (PACKAGE.parent / ".git").exists():
        return None
    commit = _git("rev-parse", "HEAD")
    if commit is None:
        return None
    return {"commit": commit, "dirty": bool(_git("status", "--porcelain", "--untracked-files=no"))}


def _git(*arguments: str) -> str | None:
    command = ["git", "-C", str(PACKAGE.parent), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:  # no git on this machine
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def write_config(
    run_dir: Path, verb: str, overrides: Sequence[str], base: str | None, cfg: DictConfig, folders: Sequence[Path] = ()
) -> None:
    """Write ``config.yaml``: the configuration as composed, with what it was made with.

    Interpolations stay as they are, so that paths of this machine do not enter. The file is itself a root
    configuration: ``dr-lab <verb> --config-dir <run_dir> --config-name config`` runs the same again. Where the user has
    a folder of files of her own, such as the model's MJCF, a second ``--config-dir`` names it; the comments on top do.

    Args:
        run_dir: the run's folder.
        verb: e.g. ``"close"``.
        overrides: what the user typed.
        base: option of the group ``base`` that the root configuration builds on; it places the runs.
        cfg: the job's configuration without Hydra's node.
        folders: configuration folders that the user gave.

    Raises:
        DrLabError: the folder cannot be written.
    """
    values = OmegaConf.to_container(cfg, resolve=False)
    if not isinstance(values, dict):
        return
    made_with: dict[str, Any] = {"overrides": list(overrides), "versions": versions(), "git": git_state()}
    defaults = ["_self_"] if base is None else [{"base": base}, "_self_"]
    body = {"defaults": defaults, **values, "made_with": made_with}
    own = _given(folders)
    typed = shlex.join(["dr-lab", verb, *own, *overrides])
    again = " ".join(["--config-dir FOLDER_OF_THIS_FILE", *filter(None, [shlex.join(own)]), "--config-name config"])
    header = f"# {typed}\n# Again: dr-lab {verb} {again}\n"
    text = header + yaml.safe_dump(body, sort_keys=False, allow_unicode=True, width=120)
    write_text(run_dir / CONFIG_FILE, text)


def _given(folders: Sequence[Path]) -> list[str]:
    """The flags that name these folders, as they may be typed here; the folder of a run that is repeated is none."""
    own = [folder for folder in folders if not (folder / CONFIG_FILE).is_file()]
    typed = [folder.relative_to(Path.cwd()) if folder.is_relative_to(Path.cwd()) else folder for folder in own]
    return [word for folder in typed for word in ("--config-dir", str(folder))]
