"""What updates add to the return over contexts: a line over one parameter, a heat map over two."""

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Chart, linear_axis
from dr_lab.recorders.heat_map import CANVAS, DOUBLE, ColourScale, cell_axis, log_map
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import Gain


def log_gain(root: Branch, gain: Gain, look: Look) -> None:
    """Draw a gain; blue is more return, orange less, and a dot marks a cell whose sign is in doubt.

    Args:
        root: where to.
        gain: its cells.
        look: colours and line widths.
    """
    if len(gain.axes) == 1:
        _log_line(root, gain, look)
        return
    known = np.abs(gain.value[np.isfinite(gain.value)])
    reach = float(known.max()) if len(known) and known.max() > 0.0 else 1.0
    chart = log_map(root, gain.axes, gain.value, ColourScale(-reach, reach, DOUBLE), look)
    place = np.argwhere(gain.doubtful & np.isfinite(gain.value))
    if len(place):
        across, up = (axis.values[index] for axis, index in zip(gain.axes, place.T, strict=True))
        chart.dots("doubtful", across, up, look.colour("ground"), look.measured_width)


def _log_line(root: Branch, gain: Gain, look: Look) -> None:
    """The mean as a line with dots, thin lines at the ends of the interval, and 0."""
    (axis,) = gain.axes
    drawn = np.concatenate([each[np.isfinite(each)] for each in (gain.value, gain.low, gain.high, np.zeros(1))])
    room = 0.05 * float(np.ptp(drawn))
    chart = Chart(
        root, CANVAS, cell_axis(axis), linear_axis("gain", float(drawn.min()) - room, float(drawn.max()) + room)
    )
    chart.frame(look.colour("axis"), look.colour("text"))
    colour = look.colour("after")
    chart.line("zero", [chart.x.low, chart.x.high], [0.0, 0.0], look.colour("text"), 0.5)
    for name, values in (("low", gain.low), ("high", gain.high)):
        known = np.isfinite(values)
        chart.line(name, axis.values[known], values[known], (*colour[:3], look.ghost_alpha), look.line_width / 2)
    known = np.isfinite(gain.value)
    chart.line("mean", axis.values[known], gain.value[known], colour, look.measured_width / 2)
    for name, of in (("sure", ~gain.doubtful & known), ("doubtful", gain.doubtful & known)):
        if of.any():
            chart.dots(name, axis.values[of], gain.value[of], colour if name == "sure" else look.colour("noise"), 4.0)
