"""How returns are distributed: a violin each, below one another on one axis."""

from collections.abc import Sequence

import numpy as np
import rerun.blueprint as rrb

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Axis, Canvas, Chart, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import Sample
from dr_lab.reports.quantity import number
from dr_lab.trajectory import Array

ROOT = "violins"
# Canvas units that a row and all rows have at least: few are higher. Shares of a row, from below, at which the middle
# of a violin is, and that are its half width; above it stands a line of text.
_ROW, _ALL = 20.0, 80.0
_MIDDLE, _HALF = 0.35, 0.3
_THIN = 0.005  # of its largest width, below which the outline begins and ends
_POINTS = 200  # of an outline
_FEW = 10  # returns, which are dots: a density of so few is no more than their bandwidth
_LEAST = 0.01  # bandwidth in widths of the axis: equal returns are a spike, not a line without width


def views(samples: Sequence[Sample]) -> list[rrb.View]:
    """The view of what `log_violins` draws; none where there are no samples."""
    return [_canvas(len(samples)).view([ROOT], "returns")] if samples else []


def log_violins(root: Branch, samples: Sequence[Sample], colours: Sequence[Colour], look: Look) -> None:
    """Draw Gaussian kernel densities of returns, each with its quartiles as a thick line and its median as a dot.

    Bandwidth: s k^(−1/5) of k returns with standard deviation s (Scott 1992, Multivariate Density Estimation). All are
    equally wide where they are widest. Ten returns or fewer are dots, for a density would tell nothing more.

    Args:
        root: where to.
        samples: the returns, one sample at least; what is not known is left out.
        colours: of each.
        look: all other colours, and line widths.
    """
    known = [sample.value[np.isfinite(sample.value)] for sample in samples]
    every = np.concatenate([*known, np.zeros(0 if any(map(len, known)) else 1)])
    low, high = float(every.min()), float(every.max())
    room = 0.05 * (high - low) or 1.0  # 1: of returns that are all the same
    x = linear_axis("return", low - room, high + room)
    chart = Chart(root, _canvas(len(samples)), x, Axis("", 0.0, float(len(samples)), []))
    chart.frame(look.colour("axis"), look.colour("text"))
    for index, (sample, returns, colour) in enumerate(zip(samples, known, colours, strict=True)):
        bottom, name = float(len(samples) - 1 - index), f"violin_{index:02}"
        told = _log_violin(chart, name, returns, bottom, colour, look) if len(returns) else "no return is known"
        above = chart.place((x.low + x.high) / 2, bottom + 1.0)[0]
        chart.words(f"{name}_label", [(above, f"{sample.name} · {told}")], look.colour("text"), lift=0.0)


def _log_violin(chart: Chart, name: str, returns: Array, bottom: float, colour: Colour, look: Look) -> str:
    """Draw one; gives its quartiles in words."""
    middle = bottom + _MIDDLE
    first, median, third = np.quantile(returns, [0.25, 0.5, 0.75]).tolist()
    if len(returns) > _FEW:
        at, width = _outline(returns, chart.x)
        across, up = np.concatenate([at, at[::-1], at[:1]]), np.concatenate([width, -width[::-1], width[:1]])
        chart.line(f"{name}_outline", across, middle + _HALF * up, colour, look.line_width / 2)
    else:
        chart.dots(
            f"{name}_returns", returns, np.full(len(returns), middle + _HALF / 2), colour, 1.5 * look.measured_width
        )
    chart.line(f"{name}_quartiles", [first, third], [middle] * 2, colour, look.measured_width)
    chart.dots(f"{name}_median", [median], [middle], look.colour("measured"), 2 * look.measured_width)
    return f"median {number(median)} · quartiles {number(first)}, {number(third)}"


def _outline(returns: Array, axis: Axis) -> tuple[Array, Array]:
    """Places along the axis and the density there over its largest value, shape (p,) each."""
    span = axis.high - axis.low
    bandwidth = max(float(returns.std()) * len(returns) ** -0.2, _LEAST * span)
    at = np.linspace(axis.low, axis.high, _POINTS)
    density = np.exp(-0.5 * np.square((at[:, None] - returns) / bandwidth)).sum(axis=1)
    drawn = np.flatnonzero(density >= _THIN * density.max())
    part = slice(drawn[0], drawn[-1] + 1)
    return at[part], density[part] / density.max()


def _canvas(rows: int) -> Canvas:
    return Canvas(130.0, max(_ALL, _ROW * rows), left=8.0, right=8.0, top=8.0, bottom=16.0)
