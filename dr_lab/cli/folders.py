"""Where configuration and examples lie; imports nothing heavy, so that `dr-lab --help` answers at once."""

import glob
import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from dr_lab import shipped as beside
from dr_lab.errors import ConfigError, UnknownNameError

PACKAGE = beside.PACKAGE

_NAMED = re.compile(r"\$\{conf:([^${}]+)\}")


def shipped() -> Path:
    """The configuration that comes with dr_lab.

    Raises:
        ConfigError: there is none (a broken installation).
    """
    return beside.shipped(PACKAGE)


def split_config_dir(arguments: Sequence[str]) -> tuple[tuple[Path, ...], list[str]]:
    """Take the user's configuration folder out of the arguments, because it must be searched before ours.

    Hydra itself searches ``--config-dir`` last, so that a file of the user's would silently lose against one of ours
    with the same name.

    Args:
        arguments: what follows the verb.

    Returns:
        Folders to search in order, and the remaining arguments.

    Raises:
        ConfigError: the flag has no value, or the folder does not exist.
    """
    folders: list[Path] = []
    rest: list[str] = []
    words = iter(arguments)
    for word in words:
        if word in ("--config-dir", "-cd"):
            folders.append(_existing(next(words, "")))
        elif word.startswith(("--config-dir=", "-cd=")):
            folders.append(_existing(word.partition("=")[2]))
        else:
            rest.append(word)
    return (*folders, shipped()), rest


def _existing(given: str) -> Path:
    folder = Path(given).expanduser().absolute()
    if not given or not folder.is_dir():
        raise ConfigError(f"--config-dir needs an existing folder; given {given!r}. It holds groups such as model/.")
    return folder


def find(folders: Sequence[Path], relative: str) -> str:
    """Absolute path of a file of the configuration; the resolver ``${conf:model/furuta.xml}``.

    Args:
        folders: folders to search, in order.
        relative: path inside a configuration folder.

    Raises:
        ConfigError: no folder has it; the message lists the files of that kind beside it.
    """
    for folder in folders:
        path = folder / relative
        if path.exists():
            return str(path)
    given = Path(relative)
    beside = {
        str(given.parent / path.name) for folder in folders for path in (folder / given.parent).glob(f"*{given.suffix}")
    }
    unknown = UnknownNameError("configuration file", relative, beside, " or ".join(map(str, folders)))
    raise ConfigError(f"{unknown} {_own(relative)}")


def own_files(configuration: Mapping[str, Any], folders: Sequence[Path]) -> dict[str, str]:
    """The files that ``${conf:…}`` finds in the user's own folders, each with the hash of what it holds.

    Args:
        configuration: as composed, interpolations unresolved.
        folders: the user's, first searched first.
    """
    hashes: dict[str, str] = {}
    for relative in _NAMED.findall(json.dumps(configuration, ensure_ascii=False, default=str)):
        path = next((path for folder in folders if (path := folder / relative).is_file()), None)
        if path is not None:
            hashes[relative] = _hash(path, path.stat().st_mtime_ns)
    return hashes


@cache
def _hash(path: Path, _: int) -> str:
    """Of a file's content, read again where its time of change is another: each job of a sweep asks."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _own(relative: str) -> str:
    """How a file of the user's own is found: as it was when the run that names it was made."""
    found = next((path for path in Path.cwd().glob(f"*/{relative}")), None)
    folder = "FOLDER" if found is None else found.relative_to(Path.cwd()).parts[0]
    lies = f"One lies in {folder}: add" if found is not None else "If it is your own, add"
    return f"{lies} --config-dir {folder}, beside other ones."


def example(relative: str) -> str:
    """Absolute path of an example that ships beside the configuration; the resolver ``${examples:furuta/*.mcap}``.

    Args:
        relative: path or glob inside ``examples/``.

    Raises:
        UnknownNameError: there is no such example.
    """
    folder = shipped().parent / "examples"
    path = folder / relative
    if not glob.glob(str(path)):
        available = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.suffix == path.suffix)
        raise UnknownNameError("example", relative, available, str(folder))
    return str(path)
