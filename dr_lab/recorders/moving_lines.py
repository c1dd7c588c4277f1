"""Lines of a chart that change with the iteration."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import ArrayLike

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import LINES
from dr_lab.recorders.shape import Colour
from dr_lab.trajectory import Array


def log_moving_lines(
    place: Branch,
    iteration: ArrayLike,
    strips: Sequence[Sequence[Array]],
    colour: Colour,
    width: float,
    layer: float = LINES,
) -> None:
    """Draw some lines at each iteration, maybe none.

    Args:
        place: where to.
        iteration: shape (k,), increasing.
        strips: for each iteration the canvas positions of lines, shape (m, 2) each.
        colour: of all of them.
        width: points on the screen.
        layer: of the drawing; what is higher covers what is lower.
    """
    place.static(rr.LineStrips2D.from_fields(colors=[colour], radii=rr.Radius.ui_points(width / 2), draw_order=layer))
    columns = rr.LineStrips2D.columns(strips=[strip for each in strips for strip in each])
    place.over_iterations(np.asarray(iteration), columns.partition([len(each) for each in strips]))
