"""The experiments that a verb can take."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from dr_lab.cli.groups import defaults_of, options

GROUP = "experiment"


def experiments(groups: Collection[str], folders: Sequence[Path]) -> dict[str, Path]:
    """The experiments that choose options of a verb's groups only, sorted.

    Args:
        groups: those of the verb.
        folders: configuration folders, first searched first.

    Returns:
        File by experiment.
    """
    files = options(GROUP, folders)
    return {name: path for name, path in files.items() if set(_chosen(name, files)) <= {*groups}}


def _chosen(name: str, files: Mapping[str, Path]) -> Iterator[str]:
    """The groups of which an experiment chooses options, itself or by what it builds on; not those within an option."""
    for entry in defaults_of(files[name]):
        if isinstance(entry, str) and entry in files:
            yield from _chosen(entry, files)
        for key in entry if isinstance(entry, dict) else ():
            if key.startswith("override ") and "@" not in key:
                yield key.removeprefix("override ").removeprefix("/")
