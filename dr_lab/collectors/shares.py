"""The state of n episodes as equal shares, for workers that each play some of them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def shares(state: Mapping[str, Any], count: int, workers: int) -> list[dict[str, Any]]:
    """Give each worker the state of its episodes, in their order.

    Args:
        state: as `Episodes.state_dict` gives it.
        count: n, a multiple of the workers.
        workers: number of shares.
    """
    width = count // workers
    parts = [slice(first, first + width) for first in range(0, count, width)]
    found = [{key: _rows(value, rows, count) for key, value in state.items()} for rows in parts]
    for part in found[1:]:
        part["infeasible"] = 0  # a count of all, which the first carries on
    return found


def joined(states: Sequence[Mapping[str, Any]], count: int) -> dict[str, Any]:
    """What `shares` took apart, put together again."""
    whole = {key: _joined([state[key] for state in states], count) for key in states[0]}
    return whole | {"infeasible": sum(state["infeasible"] for state in states)}


def _rows(value: Any, rows: slice, count: int) -> Any:  # noqa: ANN401 (whatever states are made of)
    if isinstance(value, tuple):
        return tuple(_rows(part, rows, count) for part in value)
    own = isinstance(value, np.ndarray | list) and len(value) == count
    return value[rows] if own else value


def _joined(values: Sequence[Any], count: int) -> Any:  # noqa: ANN401
    first = values[0]
    if isinstance(first, tuple):
        return tuple(_joined(parts, count) for parts in zip(*values, strict=True))
    own = isinstance(first, np.ndarray | list) and sum(map(len, values)) == count
    if not own:
        return first
    return np.concatenate(values) if isinstance(first, np.ndarray) else [each for value in values for each in value]
