"""What a job of a sweep leaves in its folder about itself: how it stands, and a lock while it is worked on.

The job alone writes there, in whatever process it runs. Its lock is one of the kernel's, so it goes with the process
that holds it, and a job that says it is running without holding the lock has died.
"""

import json
import shutil
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Literal

from dr_lab.files import write_text

STATUS_FILE = "status.json"
LOCK_FILE = ".lock"
ERROR_FILE = "error.txt"

Stored = Literal["running", "completed", "failed", "pruned"]
State = Literal["waiting", "unfinished", "unrecorded"] | Stored
FINAL: tuple[State, ...] = ("completed", "pruned")


@dataclass(frozen=True)
class Status:
    """How a job stands.

    Attributes:
        state: ``waiting`` (not begun), ``running``, ``unfinished`` (its process died), ``completed``, ``failed``,
            ``pruned`` (a study gave it up) or ``unrecorded`` (it failed before it could say so in its folder).
        error: what went wrong, for the user; empty unless it failed.
        seconds: how long its last attempt took; None unless that ended.
        mark: differs from one writing to the next, so that an attempt that ended as the one before can be told from it.
    """

    state: State
    error: str = ""
    seconds: float | None = None
    mark: str = ""


def write_status(folder: Path, state: Stored, error: str = "", seconds: float | None = None) -> None:
    """Say in a job's folder how it stands.

    Args:
        folder: the job's.
        state: how it stands.
        error: what went wrong.
        seconds: how long the attempt took.

    Raises:
        DrLabError: the folder cannot be written.
    """
    status = Status(state, error, None if seconds is None else round(seconds, 3), uuid.uuid4().hex)
    write_text(folder / STATUS_FILE, json.dumps(asdict(status), ensure_ascii=False) + "\n")


def read_status(folder: Path) -> Status:
    """How a job stands, seen from outside.

    Args:
        folder: the job's.
    """
    status = _stored(folder)
    if status.state == "running" and not _is_held(folder):
        # It may have ended between the two looks.
        again = _stored(folder)
        return replace(again, state="unfinished") if again.state == "running" else again
    return status


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Work on a job alone; waits while another process does, such as one that outlived the sweep that started it.

    Args:
        folder: the job's, which exists.
    """
    from filelock import FileLock  # noqa: PLC0415  takes a tenth of a second, which every command would pay

    with FileLock(folder / LOCK_FILE):
        yield


def clear(folder: Path) -> None:
    """Remove what an earlier attempt left, so that a job can start over.

    Args:
        folder: the job's, which this process holds.
    """
    for path in folder.iterdir():
        if path.name == LOCK_FILE:
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()


def _stored(folder: Path) -> Status:
    try:
        text = (folder / STATUS_FILE).read_text(encoding="utf-8")
    except FileNotFoundError:
        return Status("waiting")
    return Status(**json.loads(text))


def _is_held(folder: Path) -> bool:
    from filelock import FileLock, Timeout  # noqa: PLC0415  see above

    try:
        with FileLock(folder / LOCK_FILE, blocking=False):
            return False
    except Timeout:
        return True
