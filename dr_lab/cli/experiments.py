"""The experiments that a verb can take."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path

from dr_lab.cli.groups import defaults_of, options

GROUP = "experiment"


def experiments(groups: Collection[str], folders: Sequence[Path]) -> dict[str, Path]:
    """The experiments that choose options of a verb's groups only, or of groups that these options bring, sorted.

    Args:
        groups: those of the verb.
        folders: configuration folders, first searched first.

    Returns:
        File by experiment.
    """
    files = options(GROUP, folders)
    chosen = {name: dict(_chosen(name, files)) for name in files}
    pairs = {pair for each in chosen.values() for pair in each.items()}  # most are chosen many times
    brought = {pair: set(_brought(*pair, folders)) for pair in pairs}
    known = {name: {*groups, *chain(*(brought[pair] for pair in each.items()))} for name, each in chosen.items()}
    return {name: files[name] for name, each in chosen.items() if set(each) <= known[name]}


def _chosen(name: str, files: Mapping[str, Path]) -> Iterator[tuple[str, str]]:
    """The groups of which an experiment chooses options, itself or by what it builds on; not those within an option.

    Each with the option.
    """
    for entry in defaults_of(files[name]):
        if isinstance(entry, str) and entry in files:
            yield from _chosen(entry, files)
        for key, option in entry.items() if isinstance(entry, dict) else ():
            if key.startswith("override ") and "@" not in key:
                yield key.removeprefix("override ").removeprefix("/"), str(option)


def _brought(group: str, option: str, folders: Sequence[Path]) -> Iterator[str]:
    """The groups that the defaults list of a group's option names, as that of ``source=model`` names ``model``.

    ``reward`` in an option of ``env`` is the group ``env/reward``.
    """
    path = options(group, folders).get(option)
    for entry in defaults_of(path) if path else ():
        for key in entry if isinstance(entry, dict) else ():
            name = key.removeprefix("override ")
            yield name.removeprefix("/") if name.startswith("/") else f"{group}/{name}"
