"""The vertical axis of a plot against time, so that two numbers at least stand beside it."""

from collections.abc import Iterable

import numpy as np
import rerun.blueprint as rrb

from dr_lab.trajectory import Array

# The viewer numbers multiples of a power of ten, and leaves them out where they are nearer than this to one another.
_LEAST = 22.0  # px
_SHEET, _BESIDE = 805.0, 45.0  # px: height of a page of a window that is 900 high, and of what a plot has but its axes
_ROOM = 0.04  # beyond what is shown, as a share of it


def numbered_axis(values: Iterable[Array], rows: int) -> rrb.ScalarAxis | None:
    """An axis that holds all values, also of bands, and reaches to the next number where else less than two were seen.

    Args:
        values: what is drawn, NaN where there is a gap.
        rows: of plots on the page.

    Returns:
        None where nothing or but one value is known.
    """
    known = np.concatenate([np.empty(0), *(value[np.isfinite(value)].ravel() for value in values)])
    if not len(known) or not np.ptp(known) > 0.0:
        return None
    low, high = reach(float(known.min()), float(known.max()), _SHEET / rows - _BESIDE)
    room = _ROOM * (high - low)
    return rrb.ScalarAxis(range=(low - room, high + room))


def reach(low: float, high: float, height: float) -> tuple[float, float]:
    """Ends of an axis, so many px high, that shows the values from low to high and two numbers."""
    step = 10.0 ** np.ceil(np.log10((high - low) * _LEAST / max(height, _LEAST)))
    first, last = np.ceil(low / step), np.floor(high / step)
    while last - first < 1:
        if (last + 1) * step - high <= low - (first - 1) * step:
            last += 1
        else:
            first -= 1
    return min(low, float(first * step)), max(high, float(last * step))
