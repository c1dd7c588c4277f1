"""Which windows are taken together: logs, blocks of neighbours, which a bootstrap resamples, and some of many."""

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]


def logs(log: Indices) -> list[Indices]:
    """Indices of the windows of each log; `log` is the index of each window's log, shape (w,)."""
    return [np.flatnonzero(log == k) for k in np.unique(log)]


def blocks(log: Indices, size: int, least: int) -> list[Indices]:
    """Indices of consecutive windows of one log, about `size` at a time.

    Args:
        log: index of each window's log, shape (w,).
        size: windows in a block.
        least: number of blocks for which blocks are made smaller; a resample of one block shows no scatter.
    """
    groups = logs(log)
    size = max(1, min(size, len(log) // least))
    return [part for group in groups for part in np.array_split(group, max(1, round(len(group) / size)))]


def spread(count: int, most: int) -> Indices:
    """At most so many of a count of places, evenly spaced, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(np.intp))
