"""How a target moved and how the model does, as the model learns of it; and how their distance falls."""

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import LINES, Axis, Canvas, Chart, decade_axis, linear_axis
from dr_lab.recorders.look import Look
from dr_lab.recorders.moving_lines import log_moving_lines
from dr_lab.recorders.shape import Colour
from dr_lab.recorders.training import Comparisons, Decline
from dr_lab.reports.quantity import titled
from dr_lab.trajectory import Array

CANVAS = Canvas(width=130.0, height=80.0, left=18.0, right=6.0, top=12.0, bottom=16.0)
_ROOM = 0.05  # of what is drawn, beyond its ends
_DOT = 2.5  # radius, points on the screen


def log_comparisons(root: Branch, comparisons: Comparisons, look: Look) -> None:
    """Draw one quantity by iteration: the target, the model at the mean, and faintly the model in drawn contexts.

    Drawn contexts may go anywhere, so that the axis is that of target and mean.

    Args:
        root: where to.
        comparisons: of the quantity, one at least.
        look: colours and line widths.
    """
    shown = comparisons.shown
    chart = Chart(root, CANVAS, *_axes(comparisons))
    chart.frame(look.colour("axis"), look.colour("text"))
    drawn = [[chart.place(c.time, each) for each in c.drawn] for c in shown]
    lines: dict[str, tuple[list[list[Array]], Colour, float]] = {
        "drawn": (drawn, look.colour("after", look.ghost_alpha), look.line_width / 2),
        "target": ([[chart.place(c.time, c.target)] for c in shown], look.colour("measured"), look.measured_width),
        "mean": ([[chart.place(c.time, c.mean)] for c in shown], look.colour("after"), look.line_width),
    }
    for layer, (name, (strips, colour, width)) in enumerate(lines.items()):
        log_moving_lines(root / name, comparisons.iteration, strips, colour, width, LINES + layer)
    chart.legend({name: lines[name][1] for name in ("target", "mean", "drawn")})


def log_decline(root: Branch, decline: Decline, look: Look) -> None:
    """Draw figures over iterations, on an axis of powers of ten.

    Args:
        root: where to.
        decline: the figures, one above 0 at least.
        look: colours and line widths.
    """
    known = {name: np.isfinite(values) & (values > 0.0) for name, values in decline.values.items()}
    drawn = np.concatenate([values[known[name]] for name, values in decline.values.items()])
    low, high = float(drawn.min()) / 1.5, float(drawn.max()) * 1.5
    across = linear_axis("iteration", float(decline.iteration[0]), float(decline.iteration[-1]))
    chart = Chart(root, CANVAS, across, decade_axis(decline.name, low, high))
    chart.frame(look.colour("axis"), look.colour("text"))
    legend = dict[str, Colour]()
    for index, (name, values) in enumerate(decline.values.items()):
        at, up = decline.iteration[known[name]], np.log10(values[known[name]])
        legend[name] = look.series(index)
        chart.line(name, at, up, legend[name], look.line_width / 2)
        chart.dots(f"{name} dots", at, up, legend[name], _DOT)
    chart.legend(legend)


def _axes(comparisons: Comparisons) -> tuple[Axis, Axis]:
    first, seen = comparisons.shown[0], [(c.target, c.mean) for c in comparisons.shown]
    finite = np.concatenate([each[np.isfinite(each)] for pair in seen for each in pair])
    low, high = float(finite.min(initial=np.inf)), float(finite.max(initial=-np.inf))
    room = _ROOM * (high - low)
    longest = max(float(c.time[-1]) for c in comparisons.shown)
    return linear_axis("time [s]", 0.0, longest), linear_axis(titled(first.name, first.unit), low - room, high + room)
