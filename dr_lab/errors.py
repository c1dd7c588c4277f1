"""Errors a user can act on: what was given, what was expected, what is available, and the remedy."""

import difflib
from collections import Counter
from collections.abc import Iterable, Sequence

MOST_LISTED = 60  # names that a message lists one by one
MOST_OFFERED = 5  # names that hold the given one and may be meant


class DrLabError(Exception):
    """Base of every error that a user can cause and mend; the command line prints it without a traceback."""


class UnknownNameError(DrLabError):
    """A name that is not among the available ones; the message lists them, and first the closest.

    Args:
        kind: what the name stands for, e.g. ``"joint"``.
        given: the name that was given.
        available: the names that exist.
        where: where it was looked up, e.g. ``"model 'furuta'"``.
    """

    def __init__(self, kind: str, given: str, available: Iterable[str], where: str) -> None:
        names = sorted(available)
        close = " or ".join(map(repr, _closest(given, names)))
        hint = f" Did you mean {close}?" if close else ""
        super().__init__(f"There is no {kind} {given!r} in {where}.{hint} Available: {_listed(names)}.")
        self.given = given
        self.available = tuple(names)


def _closest(given: str, names: Sequence[str]) -> list[str]:
    """The name that is most like the given one; else those that begin with it or hold it, where they are few."""
    if close := difflib.get_close_matches(given, names, n=1):
        return close
    part = given.lower()
    held = sorted((name for name in names if part and part in name.lower()), key=lambda name: name.lower().find(part))
    return held if len(held) <= MOST_OFFERED else []


def _listed(names: Sequence[str]) -> str:
    """All names; where they are many, those of a folder in one, and then those of the same first word, if several."""
    for separator in ("/", "_"):
        if len(names) > MOST_LISTED:
            cut = [name.partition(separator) for name in names]
            times = Counter(f"{first}{found}" for first, found, _ in cut)
            stubs = (
                f"{first}{found}…" if found and times[f"{first}{found}"] > 1 else name
                for (first, found, _), name in zip(cut, names, strict=True)
            )
            names = list(dict.fromkeys(stubs))
    return ", ".join(names) or "none"


class DataError(DrLabError):
    """Measurements that break the data contract (missing, empty, cut, no overlap, not finite …)."""


class ModelError(DrLabError):
    """A model, parameter or effect that does not compile or does nothing; keeps MuJoCo's message."""


class ConfigError(DrLabError):
    """A configuration that cannot be run (missing value, wrong type, unknown key)."""
