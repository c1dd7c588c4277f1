"""Which logs, or parts of logs, are fitted and which are held out."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from glob import glob
from os.path import expandvars
from pathlib import Path

from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.measurements.log_file import KINDS, is_bag, kind, stem

_SEGMENT = re.compile(r"(?P<log>.+)\[(?P<start>[^:\[\]]*):(?P<stop>[^:\[\]]*)\]")
_VARIABLE = re.compile(r"\$\{?(?P<name>[A-Za-z_]\w*)\}?")


@dataclass(frozen=True)
class Part:
    """A log or a stretch of one.

    Attributes:
        name: the log's, with the stretch that the user wrote behind it.
        log: the whole log's name.
        start: s, first time taken.
        stop: s, last time taken.
    """

    name: str
    log: str
    start: float = -float("inf")
    stop: float = float("inf")


def until(name: str, stop: float) -> str:
    """Name of a log, or of a stretch of one, up to so many seconds."""
    part = _SEGMENT.fullmatch(name)
    return f"{part['log']}[{part['start']}:{stop:.1f}]" if part else f"{name}[:{stop:.1f}]"


def find_files(patterns: Sequence[str]) -> dict[str, Path]:
    """Expand file names, globs (``*``, ``**``) and folders with logs of one kind to files and bag folders by stem.

    They are sorted by path.

    Raises:
        DataError: a file does not exist, a glob matches nothing, two files share a stem, or a name still holds an
            environment variable that is not set.
    """
    paths = sorted({path for pattern in patterns for path in _expand(str(pattern))})
    files: dict[str, Path] = {}
    for path in paths:
        name = stem(path)
        if name in files:
            raise DataError(f"{files[name]} and {path} have the same stem, which names the log; rename one.")
        files[name] = path
    return files


def split(
    logs: Collection[str], fit: Sequence[str] | None, held_out: Sequence[str] | None
) -> tuple[tuple[Part, ...], tuple[Part, ...]]:
    """Assign logs to fitting and to scoring.

    A name is a log's, or ``name[a:b]`` for the seconds a to b of it; an empty a or b means its beginning or end. The
    wildcards ``*`` (any text), ``?`` (one character) and ``[05]`` (one of these) take every log that fits.

    Args:
        logs: names of all logs.
        fit: names; None takes every log that is not held out.
        held_out: names; None holds nothing out.

    Returns:
        Parts to fit on, parts held out.

    Raises:
        UnknownNameError: no such log.
        ConfigError: nothing is named, or the same data are in both.
    """
    scored = _all_parts(held_out or (), logs)
    if fit is None:
        used = {part.log for part in scored}
        fitted = tuple(Part(name, name) for name in logs if name not in used)
    else:
        fitted = _all_parts(fit, logs)
    if not fitted and not scored:
        raise ConfigError("Neither fit nor held_out names a log; give at least one of: " + ", ".join(logs) + ".")
    for a in fitted:
        for b in scored:
            if a.log == b.log and a.start < b.stop and b.start < a.stop:
                raise ConfigError(
                    f"Logs {a.name!r} (fit) and {b.name!r} (held_out) share data; a held-out log is never fitted."
                )
    return fitted, scored


def named(names: Sequence[str], logs: Collection[str]) -> frozenset[str]:
    """The whole logs that names or wildcards stand for.

    Raises:
        UnknownNameError: no such log.
    """
    return frozenset(part.log for part in _all_parts(names, logs))


def _expand(pattern: str) -> list[Path]:
    pattern = expandvars(pattern)
    unset = _VARIABLE.search(pattern)
    if unset:
        name = unset["name"]
        raise DataError(
            f"Environment variable {name} is not set, which {pattern!r} needs. Set it to the folder that holds the "
            f"data: export {name}=FOLDER."
        )
    path = Path(pattern).expanduser()
    if path.is_file() or is_bag(path):
        return [path]
    found = [each for name in glob(str(path), recursive=True) if (each := Path(name)).is_file() or is_bag(each)]
    if found:
        return found
    if path.is_dir():
        return _within(path)
    missing = "No file matches" if any(mark in pattern for mark in "*?[") else "There is no file"
    raise DataError(f"{missing} {pattern!r}; {_contents(path.parent)}. Correct logs.")


def _within(folder: Path) -> list[Path]:
    """All logs in a folder, where they are of one kind."""
    logs = [each for each in sorted(folder.iterdir()) if kind(each) in KINDS]
    kinds = sorted({kind(each) for each in logs})
    if len(kinds) == 1:
        return logs
    if not logs:
        raise DataError(f"{folder} is a folder; {_contents(folder)}. Name logs.")
    example = f"{folder}/*{logs[0].suffix}"
    raise DataError(f"{folder} is a folder with logs of several kinds. Name those of one, e.g. {example}.")


def _contents(folder: Path) -> str:
    if not folder.is_dir():
        above = next(parent for parent in folder.parents if parent.exists())
        return f"there is no folder {folder}; {_contents(above)}"
    names = sorted(entry.name + ("/" if entry.is_dir() else "") for entry in folder.iterdir())
    shown = ", ".join(names[:10]) + (" …" if len(names) > 10 else "")
    return f"folder {folder} holds {shown or 'nothing'}"


def _all_parts(names: Sequence[str], logs: Collection[str]) -> tuple[Part, ...]:
    """Each part once, though several names may stand for it."""
    return tuple(dict.fromkeys(part for name in names for part in _parts(str(name), logs)))


def _parts(name: str, logs: Collection[str]) -> list[Part]:
    """The logs, or stretches of logs, that a name stands for."""
    if name in logs:
        return [Part(name, name)]
    match = _SEGMENT.fullmatch(name)
    log, stretch = (match["log"], name[match.end("log") :]) if match else (name, "")
    found = [each for each in logs if each == log or (_is_pattern(log) and fnmatchcase(each, log))]
    if not found:
        raise UnknownNameError("log", log, logs, "logs")
    start, stop = _seconds(name, match["start"], match["stop"]) if match else (-float("inf"), float("inf"))
    return [Part(each + stretch, each, start, stop) for each in found]


def _is_pattern(name: str) -> bool:
    return any(mark in name for mark in "*?[")


def _seconds(name: str, first: str, last: str) -> tuple[float, float]:
    try:
        start, stop = float(first or "-inf"), float(last or "inf")
    except ValueError as error:
        raise ConfigError(f"{name!r} is not name[a:b] with a and b in seconds, e.g. log_1[0:3.8].") from error
    if start >= stop:
        raise ConfigError(f"{name!r}: the segment ends before it begins.")
    return start, stop
