"""The folder of a finished training run of which something is taken over, and what to say where it does not fit."""

import re
from pathlib import Path

from dr_lab.errors import DataError
from dr_lab.run_command import verb_of
from dr_lab.training.plan import CHECKPOINT

_SHOWN = 3  # parts of networks, or runs, that are named
_SIZES = re.compile(
    r"size mismatch for ([\w.]+): copying a param with shape torch\.Size\(\[([\d, ]*)\]\) from checkpoint, "
    r"the shape in current model is torch\.Size\(\[([\d, ]*)\]\)"
)
_NAMES = re.compile(r"(Missing|Unexpected) key\(s\) in state_dict: ((?:\"[^\"]+\"(?:, )?)+)")


def require_run(folder: Path, given: str, remedy: str) -> Path:
    """The folder itself, where it is that of a training run.

    Args:
        folder: where the run should lie.
        given: how it was named, for the message; empty where the folder says it.
        remedy: what to do otherwise, a sentence.

    Raises:
        DataError: there is no such folder, or it holds no checkpoint.
    """
    begin = f"{given}: " if given else ""
    if not folder.is_dir():
        raise DataError(f"{begin}There is no folder {folder}. {remedy}{_runs_in(folder.parent)}")
    if not (folder / CHECKPOINT).is_file():
        verb = verb_of(folder)
        origin = f"; it is that of a run of dr-lab {verb}" if verb else ""
        near = _runs_in(folder) or _runs_in(folder.parent)
        raise DataError(f"{begin}{folder} holds no {CHECKPOINT}{origin}. {remedy}{near}")
    return folder


def difference(error: Exception) -> str:
    """In what a run differs, told by the error of loading its state into an algorithm of other networks; a sentence."""
    text = str(error)
    found = [f"{name} is {_size(there)} there, {_size(here)} here" for name, there, here in _SIZES.findall(text)]
    for which, listed in _NAMES.findall(text):
        where = "here alone" if which == "Missing" else "there alone"
        found += [f"{name} is {where}" for name in re.findall(r"\"([^\"]+)\"", listed)]
    if isinstance(error, KeyError):
        found = [f"{error.args[0]} is here alone"]
    if not found:
        return f"{' '.join(text.split()).rstrip('.')}."
    more = f"; and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return f"{'; '.join(found[:_SHOWN])}{more}."


def _size(shape: str) -> str:
    return "×".join(shape.split(", ")) if shape else "a single number"


def _runs_in(folder: Path) -> str:
    """The newest training runs in a folder, as a sentence; nothing where there are none."""
    found = sorted(folder.glob(f"*/{CHECKPOINT}"), key=lambda path: path.stat().st_mtime, reverse=True)
    names = ", ".join(str(path.parent) for path in found[:_SHOWN])
    more = f" and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return f" Available: {names}{more}." if found else ""
