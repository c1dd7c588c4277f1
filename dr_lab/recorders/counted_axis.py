"""The horizontal axis of a plot over what training counts."""

import rerun as rr
import rerun.blueprint as rrb


def counted_axis(first: int, last: int) -> rrb.TimeAxis:
    """An axis that shows all of a plot at first: left to itself the viewer shows a part, about the slider.

    Args:
        first: iteration or control step at its left end.
        last: that at its right end.
    """
    ends = (rr.TimeRangeBoundary.absolute(seq=at) for at in (first, last))
    return rrb.TimeAxis(view_range=rr.TimeRange(*ends))
