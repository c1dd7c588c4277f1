"""The groups of the configuration: their options, and which of these stand side by side."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from dr_lab.errors import ConfigError

GLOBAL = "_global_"
_ASKS = (": ???", "oc.select:effect.run,")  # how an option asks the user for something

# libyaml's, where it is: the help of a verb reads hundreds of files
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def options(group: str, folders: Sequence[Path]) -> dict[str, Path]:
    """The options of a group, sorted; a user's file hides ours of the same name.

    Args:
        group: e.g. ``"model"``.
        folders: configuration folders, first searched first.

    Returns:
        File by option.
    """
    files = {path.stem: path for folder in reversed(folders) for path in (folder / group).glob("*.yaml")}
    return dict(sorted(files.items()))


def nested_options(group: str, folders: Sequence[Path]) -> list[str]:
    """The options of a group that lie in folders of it, such as ``hopper/torso_size``, sorted.

    A folder that a defaults list of the group's options names is a group of its own.

    Args:
        group: e.g. ``"env/context"``.
        folders: configuration folders, first searched first.
    """
    groups = {name for path in options(group, folders).values() for name in subgroups(path)}
    found = {p.relative_to(folder / group) for folder in folders for p in (folder / group).glob("*/**/*.yaml")}
    return sorted(path.with_suffix("").as_posix() for path in found if path.parts[0] not in groups)


def subgroups(path: Path) -> Iterator[str]:
    """What an option's defaults list calls the groups that lie in folders beside it."""
    for entry in defaults_of(path):
        for key in entry if isinstance(entry, dict) else ():
            yield re.split("[/@]", key.split()[-1])[0]


def defaults_of(path: Path) -> list[str | dict[str, object]]:
    """The defaults list of a configuration file; empty where it is no valid yaml, which is said when it is chosen.

    Args:
        path: a yaml file.
    """
    text = path.read_text(encoding="utf-8")
    if "defaults" not in text:  # as in most of hundreds
        return []
    try:
        content = yaml.load(text, Loader=LOADER)
    except yaml.YAMLError:
        return []
    entries = content.get("defaults") if isinstance(content, dict) else None
    return entries if isinstance(entries, list) else []


def every(group: str, folders: Sequence[Path]) -> list[str]:
    """What a group's option ``all`` stands for, the resolver ``${every:effect}``: a new file joins it by being there.

    An option that leaves a value to the user (``???``), or takes it from a run that the user names (``effect.run``),
    is not part of it.

    Args:
        group: one whose options stand side by side.
        folders: configuration folders, first searched first.

    Raises:
        ConfigError: an option does not stand beside its neighbours.
    """
    files = side_by_side(options(group, folders))
    texts = {name: path.read_text(encoding="utf-8") for name, path in files.items()}
    return [name for name, text in texts.items() if not any(mark in text for mark in _ASKS)]


def side_by_side(files: dict[str, Path]) -> dict[str, Path]:
    """The options of a group that can be chosen together: each declares a package of its own, ``<something>.<option>``.

    Args:
        files: file by option.

    Raises:
        ConfigError: an option does not stand beside its neighbours.
    """
    for fault in misplaced(files).values():
        raise ConfigError(fault)
    return {name: files[name] for name in _beside(files)}


def misplaced(files: dict[str, Path]) -> dict[str, str]:
    """What is wrong with options that do not stand beside their neighbours, though these stand side by side.

    Args:
        files: file by option.
    """
    beside = _beside(files)
    package = next(iter(beside.values()), "")
    return {
        name: f"{path}: its first line must be '# @package {package}.{name}', as its neighbours have."
        for name, path in files.items()
        if beside and name not in beside and _package(path) != GLOBAL
    }


def _beside(files: dict[str, Path]) -> dict[str, str]:
    """The options that declare a package of their own, and the ``<something>`` before their name in it."""
    packages = {name: _package(path) for name, path in files.items()}
    return {name: text.removesuffix(f".{name}") for name, text in packages.items() if text.endswith(f".{name}")}


def _package(path: Path) -> str:
    """The package that a file's first line declares, or nothing."""
    words = path.read_text(encoding="utf-8").partition("\n")[0].split()
    return words[2] if words[:2] == ["#", "@package"] and len(words) == 3 else ""
