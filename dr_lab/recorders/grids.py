"""Returns over a grid of contexts: a line over one parameter, a heat map over two."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Chart, linear_axis
from dr_lab.recorders.heat_map import CANVAS, DARK_TO_LIGHT, ColourScale, cell_axis, log_map
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import ContextAxis, Grid, over_what
from dr_lab.reports.quantity import titled


def log_grid(root: Branch, grid: Grid, look: Look, span: tuple[float, float] | None = None) -> None:
    """Draw returns over one or two parameters; infeasible contexts stay empty.

    Args:
        root: where to.
        grid: the returns.
        look: colours and line widths.
        span: lowest and highest return shown, so that several grids can be compared; None for the grid's own.
    """
    low, high = span or return_span([grid])
    if len(grid.axes) == 1:
        _log_line(root, grid, low, high, look)
    else:
        log_map(root, grid.axes, grid.mean, ColourScale(low, high, DARK_TO_LIGHT), look)


def return_span(grids: Sequence[Grid]) -> tuple[float, float]:
    """Lowest and highest return that is drawn of all grids; 0 and 1 where there is none.

    Maps show means alone, lines also what lies a standard deviation off.
    """
    off = {1: (-1.0, 1.0), 2: (0.0,)}
    drawn = [grid.mean + sign * grid.spread for grid in grids for sign in off[len(grid.axes)]]
    known = np.concatenate([np.empty(0), *(each[np.isfinite(each)] for each in drawn)])
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)


def told(grids: Sequence[Grid]) -> str:
    """What a title says of how grids over the same parameters are drawn."""
    if len(grids[0].axes) > 1:
        return ""
    hatched = not all(np.isfinite(grid.mean).all() for grid in grids)
    return f" (thin: ± std over {over_what(grids)}{', hatched: infeasible' * hatched})"


def log_lines(
    root: Branch, lines: Mapping[str, Grid], colours: Mapping[str, Colour], look: Look, span: tuple[float, float]
) -> None:
    """Draw returns over one parameter of several runs in one chart.

    Args:
        root: where to.
        lines: grids over the same parameter by what the legend calls them, one at least.
        colours: of each of them.
        look: all other colours, and line widths.
        span: lowest and highest return shown.
    """
    axes = [grid.axes[0] for grid in lines.values()]
    across = [cell_axis(axis) for axis in axes]
    low, high = min(axis.low for axis in across), max(axis.high for axis in across)
    chart = Chart(root, CANVAS, linear_axis(titled(axes[0].name, axes[0].unit), low, high), _returns(*span))
    chart.frame(look.colour("axis"), look.colour("text"))
    for index, (label, grid) in enumerate(lines.items()):
        _log_cells(Chart(root / str(index), CANVAS, chart.x, chart.y), grid, look, colours[label])
    chart.legend({label: colours[label] for label in lines})


def _log_line(root: Branch, grid: Grid, low: float, high: float, look: Look) -> None:
    (axis,) = grid.axes
    chart = Chart(root, CANVAS, cell_axis(axis), _returns(low, high))
    chart.frame(look.colour("axis"), look.colour("text"))
    _log_cells(chart, grid, look, look.colour("after"))


def _log_cells(chart: Chart, grid: Grid, look: Look, colour: Colour) -> None:
    """The mean as a line with dots, and thin lines a standard deviation off; contexts without a return are hatched."""
    (axis,) = grid.axes
    known = np.isfinite(grid.mean)
    chart.hatch("infeasible", _spans(axis, ~known), colour)
    faint = (*colour[:3], look.ghost_alpha)
    for side, sign in (("below", -1.0), ("above", 1.0)):
        edge = (grid.mean + sign * grid.spread)[known]
        chart.line(side, axis.values[known], edge, faint, look.line_width / 2)
    chart.line("mean", axis.values[known], grid.mean[known], colour, look.measured_width / 2)
    chart.dots("cells", axis.values[known], grid.mean[known], colour, look.measured_width)


def _spans(axis: ContextAxis, of: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Where cells begin and end, half way to those beside them; neighbours are one span."""
    middles = (axis.values[1:] + axis.values[:-1]) / 2
    whole = cell_axis(axis)
    edges = np.concatenate([[whole.low], middles, [whole.high]])
    change = np.flatnonzero(np.diff(np.concatenate([[False], of, [False]]).astype(int)))
    return [(float(edges[first]), float(edges[last])) for first, last in change.reshape(-1, 2)]


def _returns(low: float, high: float) -> Axis:
    room = 0.05 * (high - low)
    return linear_axis("return", low - room, high + room)
