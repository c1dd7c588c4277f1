"""The way of a learned distribution through the whole of training, as one picture."""

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Chart, linear_axis
from dr_lab.recorders.heat_map import CANVAS, DARK_TO_LIGHT, ColourScale, log_picture, pixels
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import Marginal
from dr_lab.trajectory import Array


def log_course(root: Branch, marginal: Marginal, look: Look) -> None:
    """Draw one parameter's probability density over iterations, dark where it is lowest.

    Args:
        root: where to.
        marginal: the histograms, two at least.
        look: colours.
    """
    first, last = (float(marginal.iteration[end]) for end in (0, -1))
    low, high = (float(marginal.edges[end]) for end in (0, -1))
    value = linear_axis(marginal.title, low, high)
    chart = Chart(root, CANVAS, linear_axis("iteration", first, last), value)
    density = course(marginal, *pixels())
    log_picture(root, density, ColourScale(float(density.min()), float(density.max()), DARK_TO_LIGHT), look)
    chart.frame(look.colour("axis"), look.colour("text"))


def course(marginal: Marginal, rows: int, columns: int) -> Array:
    """Density of every pixel, rows from the largest value down, columns from the first iteration on.

    A pixel shows the histogram that was taken last before its middle.

    Args:
        marginal: the histograms, two at least.
        rows: of pixels.
        columns: of pixels.

    Returns:
        Shape (rows, columns).
    """
    density = marginal.probability / np.diff(marginal.edges)
    at, value = (
        low + (np.arange(count) + 0.5) / count * (high - low)
        for low, high, count in ((*marginal.iteration[[0, -1]], columns), (*marginal.edges[[0, -1]], rows))
    )
    taken = np.searchsorted(marginal.iteration, at, side="right") - 1
    bins = np.searchsorted(marginal.edges, value[::-1], side="right") - 1
    return density.T[np.ix_(bins, taken)]
