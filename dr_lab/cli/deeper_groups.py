"""Groups that stand below another one, such as ``target@evaluator.target``, and which option brings them."""

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from dr_lab.cli.experiments import GROUP as EXPERIMENT
from dr_lab.cli.groups import defaults_of, options

_HERE = "_here_"
_DEPTH = 4  # of groups below groups


def ending_in(word: str, groups: Collection[str], folders: Sequence[Path]) -> dict[str, tuple[str, str]]:
    """The groups that are called `word` and stand below those of a verb, the least deep ones, by their spelling.

    Args:
        word: e.g. ``"target"``.
        groups: those of the verb, e.g. ``"evaluator"``.
        folders: configuration folders, first searched first.

    Returns:
        Group and option that bring it, ``("evaluator", "real_vs_sim")``, by ``"target@evaluator.target"``.
    """
    found: dict[str, tuple[str, str]] = {}
    for group in groups:
        if group == EXPERIMENT or "/" in group:
            continue
        for option, path in options(group, folders).items():
            for below, package in _below(group, group, path, folders, _DEPTH):
                called = word in (below, below.rpartition("/")[2], package.rpartition(".")[2])
                if called and below not in groups:
                    found.setdefault(f"{below}@{package}", (group, option))
    least = min((spelling.count(".") for spelling in found), default=0)
    return {spelling: by for spelling, by in found.items() if spelling.count(".") == least}


def _below(group: str, package: str, path: Path, folders: Sequence[Path], depth: int) -> Iterator[tuple[str, str]]:
    """Groups below an option of a group, each with its package, from its defaults list and those of their options."""
    for entry in defaults_of(path):
        for key in entry if isinstance(entry, dict) else ():
            name, _, place = key.partition("@")
            if " " in key or place == _HERE or not depth:  # one that overrides another is listed there
                continue
            inner = name[1:] if name.startswith("/") else f"{group}/{name}"
            inside = f"{package}.{place or name.removeprefix('/').replace('/', '.')}"
            yield inner, inside
            for file in options(inner, folders).values():
                yield from _below(inner, inside, file, folders, depth - 1)
