"""The configurations of runs: what of them tells the runs apart."""

import functools
from collections.abc import Mapping, Sequence
from typing import Any

_RECORDED = ("defaults", "made_with", "outputs")  # what the command line adds, and where it put the run


def experiment(configuration: Mapping[str, Any], ignored: Sequence[str]) -> Mapping[str, Any]:
    """What of a configuration decides on the results.

    Args:
        configuration: of a run, its ``config.yaml``.
        ignored: keys that do not, as overrides spell them.
    """
    return functools.reduce(without, [*_RECORDED, *ignored], configuration)


def without(configuration: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A configuration but for a key, the same where it does not have it.

    Args:
        configuration: of a run.
        key: as overrides spell it, ``a.b``, ``a/b`` or ``group@a.b``; names may hold dots, too.
    """
    return _without(configuration, key.rpartition("@")[2].replace("/", "."))


def holds(configuration: Mapping[str, Any], key: str) -> bool:
    """Whether a configuration has a key, spelt as in overrides."""
    return without(configuration, key) != configuration


def flat(configuration: Mapping[str, Any], above: str = "") -> dict[str, str]:
    """The values of a configuration by their keys.

    Args:
        configuration: of a run.
        above: what comes before the keys.
    """
    found: dict[str, str] = {}
    for name, value in configuration.items():
        found |= flat(value, f"{above}{name}.") if isinstance(value, Mapping) else {f"{above}{name}": str(value)}
    return found


def _without(configuration: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    return {
        name: _without(value, key.removeprefix(f"{name}."))
        if isinstance(value, Mapping) and key.startswith(f"{name}.")
        else value
        for name, value in configuration.items()
        if name != key
    }
