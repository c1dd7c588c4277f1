"""What a user types on the command line to go on from a run."""

import re
import shlex
from pathlib import Path

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Quote, QuotedString

from dr_lab.run_command import config_dirs_of


def typed(key: str, value: Path | str) -> str:
    """``key=value``: quoted for the shell and for Hydra, to which signs are grammar and some words are no text."""
    text = str(value)
    shown = text if _is_text(text) else QuotedString(text, Quote.single).with_quotes()
    return shlex.quote(f"{key}={shown}")


def view_command(run: Path | str) -> str:
    """`dr-lab view` on a run's folder or recording."""
    return f"dr-lab view {typed('run', run)}"


def add_formula_command(run: Path | str, joint: str, measurements: str) -> str:
    """`dr-lab add` of the formula that a run's report has for a joint, to the model that the run ended with."""
    own = shlex.join(["add", *config_dirs_of(Path(run))])
    site, found, model = typed("effect.joint", joint), typed("effect.run", run), typed("model.run", run)
    return f"dr-lab {own} effect=formula {site} {found} model=from_run {model} {typed('measurements', measurements)}"


def _is_text(value: str) -> bool:
    """Whether Hydra reads a value as the text that it is; ``17``, ``null`` and ``true`` are none to it."""
    plain = re.fullmatch(r"[\w./ -]+", value, re.ASCII)
    return plain is not None and OverridesParser.create().parse_override(f"key={value}").value() == value
