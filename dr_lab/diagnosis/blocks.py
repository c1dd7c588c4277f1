"""Blocks of neighbouring windows, which a bootstrap resamples together."""

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]


def blocks(log: Indices, size: int | None = None) -> list[Indices]:
    """Indices of consecutive windows of one log, about `size` at a time; None takes whole logs.

    Args:
        log: index of each window's log, shape (w,).
        size: windows in a block.
    """
    groups = [np.flatnonzero(log == k) for k in np.unique(log)]
    if size is None:
        return groups
    return [part for group in groups for part in np.array_split(group, max(1, round(len(group) / size)))]
