"""How returns are distributed: a violin each, below one another on one axis."""

from collections.abc import Sequence

import numpy as np
import rerun.blueprint as rrb

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import Violin
from dr_lab.reports.quantity import number
from dr_lab.trajectory import Array

ROOT = "violins"
# Canvas units a row: a line of text above a violin, whose middle and half width are shares of the row from below.
_ROW, _MIDDLE, _HALF = 20.0, 0.35, 0.3
_ROOM = 4  # rows that fill the view; fewer leave room below
_POINTS = 200  # of an outline
_LEAST = 0.01  # bandwidth in widths of the axis: equal returns are a spike, not a line without width


def views(violins: Sequence[Violin]) -> list[rrb.View]:
    """The view of what `log_violins` draws; none where there are no violins."""
    return [_canvas(len(violins)).view([ROOT], "returns")] if violins else []


def log_violins(root: Branch, violins: Sequence[Violin], colours: Sequence[Colour], look: Look) -> None:
    """Draw Gaussian kernel densities of returns, each with its quartiles as a thick line and its median as a dot.

    Bandwidth: s k^(−1/5) of k returns with standard deviation s (Scott 1992, Multivariate Density Estimation). All are
    equally wide where they are widest.

    Args:
        root: where to.
        violins: the returns, one violin at least.
        colours: of each.
        look: all other colours, and line widths.
    """
    every = np.concatenate([violin.returns for violin in violins])
    low, high = float(every.min()), float(every.max())
    room = 0.05 * (high - low)
    x = linear_axis("return", low - room, high + room)
    chart = Chart(root, _canvas(len(violins)), x, Axis("", 0.0, float(len(violins)), []))
    chart.frame(look.colour("axis"), look.colour("text"))
    for index, (violin, colour) in enumerate(zip(violins, colours, strict=True)):
        _log_violin(chart, f"violin_{index:02}", violin, float(len(violins) - 1 - index), colour, look)


def _log_violin(chart: Chart, name: str, violin: Violin, bottom: float, colour: Colour, look: Look) -> None:
    middle = bottom + _MIDDLE
    first, median, third = np.quantile(violin.returns, [0.25, 0.5, 0.75]).tolist()
    at, width = _outline(violin.returns, chart.x)
    across, up = np.concatenate([at, at[::-1]]), np.concatenate([width, -width[::-1]])
    chart.line(f"{name}_outline", across, middle + _HALF * up, colour, look.line_width / 2)
    chart.line(f"{name}_quartiles", [first, third], [middle] * 2, colour, look.measured_width)
    chart.dots(f"{name}_median", [median], [middle], look.colour("measured"), 2 * look.measured_width)
    above = chart.place((chart.x.low + chart.x.high) / 2, bottom + 1.0)[0]
    text = f"{violin.name} · median {number(median)} · quartiles {number(first)}, {number(third)}"
    chart.words(f"{name}_label", [(above, text)], look.colour("text"), lift=0.0)


def _outline(returns: Array, axis: Axis) -> tuple[Array, Array]:
    """Places along the axis and the density there over its largest value, shape (p,) each."""
    span = axis.high - axis.low
    bandwidth = max(float(returns.std()) * len(returns) ** -0.2, _LEAST * span)
    at = np.linspace(axis.low, axis.high, _POINTS)
    density = np.exp(-0.5 * np.square((at[:, None] - returns) / bandwidth)).sum(axis=1)
    return at, density / density.max()


def _canvas(rows: int) -> Canvas:
    height = _ROW * max(rows, 1)
    spare = max(0.0, _ROW * _ROOM - height)
    return Canvas(130.0, height, left=8.0, right=8.0, top=8.0, bottom=16.0 + spare)
