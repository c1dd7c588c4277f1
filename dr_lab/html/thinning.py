"""Fewer points that draw the same curve: the lowest and the highest of every stretch."""

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array

Numbers = NDArray[np.floating] | NDArray[np.integer]


def thinned(time: Numbers, value: Array, most: int) -> tuple[Numbers, Array]:
    """At most about so many points of a curve; what stands out stays, and a gap stays a gap.

    The samples are dealt into most / 2 stretches of equal count; of each stay the lowest and the highest, and one that
    is NaN where there is one.

    Args:
        time: shape (n,).
        value: shape (n,); NaN is a gap.
        most: points, ≥ 2; those of gaps come on top.

    Returns:
        Time and value, shape (k,) each.
    """
    if len(time) <= most:
        return time, value
    count = most // 2
    size = -(-len(time) // count)
    index = np.arange(count * size).reshape(count, size)
    padded = np.pad(value, (0, count * size - len(value)), constant_values=np.nan).reshape(count, size)
    known, inside = np.isfinite(padded), index < len(value)
    lowest = np.where(known, padded, np.inf).argmin(1)
    highest = np.where(known, padded, -np.inf).argmax(1)
    gap, rows = (~known & inside).argmax(1), np.arange(count)
    kept = [index[rows, at][has] for at, has in ((lowest, known.any(1)), (highest, known.any(1)))]
    places = np.unique(np.concatenate([*kept, index[rows, gap][(~known & inside).any(1)]]))
    return time[places], value[places]


def spread(count: int, most: int) -> NDArray[np.intp]:
    """At most so many of a count of places, evenly spaced, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(np.intp))
