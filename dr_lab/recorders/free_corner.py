"""Where a legend hides least: the viewer writes it into a corner of the plot."""

from collections.abc import Sequence

import numpy as np
import rerun.blueprint as rrb

from dr_lab.trajectory import Array

# What a legend of a few short names takes of a plot, as shares of its width and height.
_ACROSS, _UP = 0.25, 0.5
_CORNERS = {
    (0, 1): rrb.Corner2D.LeftTop,
    (1, 1): rrb.Corner2D.RightTop,
    (0, 0): rrb.Corner2D.LeftBottom,
    (1, 0): rrb.Corner2D.RightBottom,
}


def free_corner(curves: Sequence[tuple[Array, Array]]) -> rrb.Corner2D:
    """The corner in which the fewest points of curves lie; of several the upper, then the left one.

    Args:
        curves: times (n,) and values (n,) or (n, k), NaN where there is a gap; shown from the lowest to the highest.
    """
    full = [(time, value) for time, value in curves if len(time)]
    pieces = [(time, column) for time, value in full for column in np.reshape(value, (len(time), -1)).T]
    x, y = (np.concatenate([np.empty(0), *parts]) for parts in zip(*pieces, strict=True)) if pieces else ([], [])
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return rrb.Corner2D.LeftTop
    across, up = (_share(np.asarray(values)[known]) for values in (x, y))
    hidden = {
        corner: int(((np.abs(across - right) < _ACROSS) & (np.abs(up - top) < _UP)).sum())
        for (right, top), corner in _CORNERS.items()
    }
    return min(hidden, key=lambda corner: hidden[corner])


def _share(value: Array) -> Array:
    return (value - value.min()) / (np.ptp(value) or 1.0)
