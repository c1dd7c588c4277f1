"""How often contexts of each kind were drawn as training went on: a heat map, colour for the share of a block."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.chart import Chart, linear_axis
from dr_lab.recorders.heat_map import CANVAS, DARK_TO_LIGHT, ColourScale, log_picture, pixels
from dr_lab.recorders.look import Look
from dr_lab.reports.quantity import counted, titled
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Sampled:
    """Contexts that were drawn for training, counted in blocks of control steps, of all runs of a group together.

    Attributes:
        group: whose they are.
        name: the parameter.
        unit: its unit.
        runs: of the group, that noted their contexts.
        frames: ends of the blocks, shape (k + 1,), control steps.
        edges: of the bins, shape (b + 1,).
        count: shape (k, b).
    """

    group: str
    name: str
    unit: str
    runs: int
    frames: NDArray[np.integer]
    edges: Array
    count: NDArray[np.integer]

    @property
    def told(self) -> str:
        """Of how many runs it is."""
        return counted(self.runs, "run")

    @property
    def share(self) -> Array:
        """Share of a block's draws that lie in each bin, shape (k, b); NaN where a block has none."""
        drawn = self.count.sum(axis=1, keepdims=True)
        return self.count / np.where(drawn > 0, drawn, np.nan)


def highest_share(sampled: Sampled) -> float:
    """End of a colour scale that begins at 0; twice what is uniform at least, so that noise has no full colour."""
    return max(2.0 / sampled.count.shape[1], float(np.nanmax(sampled.share)))


def log_sampled(root: Branch, sampled: Sampled, look: Look, highest: float) -> None:
    """Draw the shares, control steps to the right.

    Args:
        root: where to.
        sampled: the counts.
        look: colours and line widths.
        highest: share that has the last colour, so that several maps can be compared.
    """
    last, (rows, columns) = float(sampled.frames[-1]), pixels()
    block = np.searchsorted(sampled.frames, (np.arange(columns) + 0.5) / columns * last, side="right") - 1
    bins = np.arange(rows) * sampled.count.shape[1] // rows
    log_picture(root, sampled.share.T[::-1][np.ix_(bins, block)], ColourScale(0.0, highest, DARK_TO_LIGHT), look)
    up = linear_axis(titled(sampled.name, sampled.unit), float(sampled.edges[0]), float(sampled.edges[-1]))
    chart = Chart(root, CANVAS, linear_axis("control steps", 0.0, last), up)
    chart.frame(look.colour("axis"), look.colour("text"))
