"""The configurations of runs: what of them tells the runs apart."""

from collections.abc import Mapping
from typing import Any


def without(configuration: Mapping[str, Any], key: str) -> dict[str, Any]:
    """A configuration but for a key, the same where it does not have it.

    Args:
        configuration: of a run.
        key: names joined by dots, which names may hold, too.
    """
    return {
        name: without(value, key.removeprefix(f"{name}."))
        if isinstance(value, Mapping) and key.startswith(f"{name}.")
        else value
        for name, value in configuration.items()
        if name != key
    }
