"""Files that are either complete or not there: write beside, flush to disk, rename."""

import os
import re
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dr_lab.errors import DrLabError

_LEFTOVER = re.compile(r"\..*\.[0-9a-f]{32}(\.\w+)?")  # the names that `atomic` gives


@contextmanager
def atomic(path: Path) -> Iterator[Path]:
    """Give a temporary path to write to; it takes the name `path` when the block ends without an error.

    The temporary file lies in the same folder (a rename is atomic only within one file system), keeps the suffix of
    `path` (some libraries choose the format by it) and is removed if the block raises, Ctrl-C included. Missing folders
    are made.

    Args:
        path: the file to write or replace.

    Yields:
        The temporary path, an empty file.

    Raises:
        DrLabError: the folder cannot be made or written to, or the disk is full when the file is flushed.
    """
    temporary = path.with_name(f".{path.stem}.{uuid.uuid4().hex}{path.suffix}")
    try:
        _make(temporary, path)
        yield temporary
        _publish(temporary, path)
    finally:
        with suppress(OSError):  # it has its name, or could not even be made
            temporary.unlink()


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files that processes left in a folder when they were killed while they wrote.

    Args:
        folder: to which nobody else writes.
    """
    for path in folder.iterdir():
        if _LEFTOVER.fullmatch(path.name):
            path.unlink()


def why_no_folder(path: Path, error: OSError) -> str:
    """What stands in the way of a folder: a file with its name or that of a folder above it, or what the system says.

    Args:
        path: of the folder.
        error: raised when it was to be made.
    """
    file = next((each for each in (path, *path.parents) if each.is_file()), None)
    return f"{error.strerror}" if file is None else f"{file} is a file"


def write_bytes(path: Path, content: bytes) -> None:
    """Write `content` to `path` atomically; see `atomic` for the errors."""
    with atomic(path) as temporary:
        try:
            temporary.write_bytes(content)
        except OSError as error:
            raise _cannot_write(path, error) from error


def write_text(path: Path, content: str) -> None:
    """Write `content` to `path` as UTF-8, atomically; see `atomic` for the errors."""
    write_bytes(path, content.encode("utf-8"))


def _make(temporary: Path, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.touch()
    except OSError as error:
        raise _cannot_write(path, error) from error


def _publish(temporary: Path, path: Path) -> None:
    """Flush the file, give it its name, then flush the folder so that the name survives a power cut too."""
    try:
        _flush(temporary)
        os.replace(temporary, path)
        _flush(path.parent)
    except OSError as error:
        raise _cannot_write(path, error) from error


def _flush(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _cannot_write(path: Path, error: OSError) -> DrLabError:
    return DrLabError(
        f"Cannot write {path}: {error.strerror}. Choose a folder that you may write to and that has room, "
        "e.g. with hydra.run.dir=FOLDER, for a sweep hydra.sweep.dir=FOLDER."
    )
