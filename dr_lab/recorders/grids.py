"""Returns over a grid of contexts: a line over one parameter, a heat map over two."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import ContextAxis, Grid
from dr_lab.reports.quantity import number, titled
from dr_lab.trajectory import Array

CANVAS = Canvas(width=130.0, height=90.0, left=18.0, right=24.0, top=12.0, bottom=16.0)
_PIXELS = 10  # of the heat map's picture, a canvas unit
_SCALE = (6.0, 8.0)  # distance and width of the colour scale beside the map


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
        _log_map(root, grid, low, high, look)


def return_span(grids: Sequence[Grid]) -> tuple[float, float]:
    """Lowest and highest return that is drawn of all grids; 0 and 1 where there is none.

    Maps show means alone, lines also what lies a standard deviation off.
    """
    off = {1: (-1.0, 1.0), 2: (0.0,)}
    drawn = [grid.mean + sign * grid.spread for grid in grids for sign in off[len(grid.axes)]]
    known = np.concatenate([np.empty(0), *(each[np.isfinite(each)] for each in drawn)])
    return (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)


def heat_map(value: Array, low: float, high: float, look: Look) -> np.ndarray:
    """Colours of a map, dark at `low` over blue to white at `high`; NaN takes the ground's colour.

    Args:
        value: shape (n, m).
        low: value of the darkest colour.
        high: value of the lightest, > low.
        look: ``fixed``, ``after`` and ``measured`` are the three stops.

    Returns:
        Red, green and blue, shape (n, m, 3), 0 … 255.
    """
    stops = np.array([look.colour(name)[:3] for name in ("fixed", "after", "measured")], dtype=float)
    share = np.clip((value - low) / max(high - low, np.finfo(float).tiny), 0.0, 1.0)
    at = np.linspace(0.0, 1.0, len(stops))
    colour = np.stack([np.interp(share, at, stops[:, channel]) for channel in range(3)], axis=-1)
    return np.where(np.isfinite(value)[..., None], colour, look.colour("ground")[:3]).astype(np.uint8)


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
    across = [linear_axis("", float(a.values[0]) - _half_cell(a), float(a.values[-1]) + _half_cell(a)) for a in axes]
    low, high = min(axis.low for axis in across), max(axis.high for axis in across)
    chart = Chart(root, CANVAS, linear_axis(titled(axes[0].name, axes[0].unit), low, high), _returns(*span))
    chart.frame(look.colour("axis"), look.colour("text"))
    for index, (label, grid) in enumerate(lines.items()):
        _log_cells(Chart(root / str(index), CANVAS, chart.x, chart.y), grid, look, colours[label])
    chart.legend({label: colours[label] for label in lines})


def _log_line(root: Branch, grid: Grid, low: float, high: float, look: Look) -> None:
    (axis,) = grid.axes
    chart = Chart(root, CANVAS, _axis(axis, _half_cell(axis)), _returns(low, high))
    chart.frame(look.colour("axis"), look.colour("text"))
    _log_cells(chart, grid, look, look.colour("after"))


def _log_cells(chart: Chart, grid: Grid, look: Look, colour: Colour) -> None:
    """The mean as a line with dots, and thin lines a standard deviation off."""
    (axis,) = grid.axes
    known = np.isfinite(grid.mean)
    faint = (*colour[:3], look.ghost_alpha)
    for side, sign in (("below", -1.0), ("above", 1.0)):
        edge = (grid.mean + sign * grid.spread)[known]
        chart.line(side, axis.values[known], edge, faint, look.line_width / 2)
    chart.line("mean", axis.values[known], grid.mean[known], colour, look.measured_width / 2)
    chart.dots("cells", axis.values[known], grid.mean[known], colour, look.measured_width)


def _returns(low: float, high: float) -> Axis:
    room = 0.05 * (high - low)
    return linear_axis("return", low - room, high + room)


def _log_map(root: Branch, grid: Grid, low: float, high: float, look: Look) -> None:
    across, up = grid.axes
    chart = Chart(root, CANVAS, _axis(across, _half_cell(across)), _axis(up, _half_cell(up)))
    rows, columns = (np.arange(n) * k // n for n, k in zip(pixels(), grid.mean.T.shape, strict=True))
    log_picture(root, grid.mean.T[::-1][np.ix_(rows, columns)], (low, high), look)
    chart.frame(look.colour("axis"), look.colour("text"))


def pixels() -> tuple[int, int]:
    """Rows and columns of a picture that fills the canvas."""
    return _PIXELS * int(CANVAS.height), _PIXELS * int(CANVAS.width)


def log_picture(root: Branch, value: Array, span: tuple[float, float], look: Look) -> None:
    """Fill the canvas with the colours of values, and draw their scale beside it.

    Args:
        root: where to.
        value: of every pixel, rows from the top down, of the shape that `pixels` gives.
        span: value of the darkest colour and of the lightest.
        look: colours.
    """
    place = root / "map"
    place.static(rr.Transform3D(scale=1 / _PIXELS))
    place.static(rr.Image(heat_map(value, *span, look)))
    _log_scale(root / "scale", *span, look)


def _log_scale(root: Branch, low: float, high: float, look: Look) -> None:
    """The colour scale, at the map's right."""
    distance, width = _SCALE
    ramp = heat_map(np.linspace(high, low, int(CANVAS.height) * _PIXELS)[:, None], low, high, look)
    place = root / "ramp"
    place.static(rr.Transform3D(scale=1 / _PIXELS, translation=[CANVAS.width + distance, 0.0, 0.0]))
    place.static(rr.Image(np.repeat(ramp, int(width) * _PIXELS, axis=1)))
    at = CANVAS.width + distance + width / 2
    words: Colour = look.colour("text")
    labels = rr.Points2D(
        [[at, -7.0], [at, CANVAS.height + 1.0]],
        labels=[number(high), number(low)],
        colors=[words],
        radii=0.0,
        show_labels=True,
    )
    (root / "ends").static(labels)


def _half_cell(axis: ContextAxis) -> float:
    """Half the distance of neighbours, by which a cell reaches beyond its middle."""
    return float(axis.values[-1] - axis.values[0]) / max(len(axis.values) - 1, 1) / 2


def _axis(axis: ContextAxis, room: float) -> Axis:
    return linear_axis(titled(axis.name, axis.unit), float(axis.values[0]) - room, float(axis.values[-1]) + room)
