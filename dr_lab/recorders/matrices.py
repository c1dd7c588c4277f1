"""Cosines between the gradients of contexts: a heat map, of which what is in doubt is marked."""

import numpy as np

from dr_lab.recorders.branch import Branch
from dr_lab.recorders.heat_map import DOUBLE, ColourScale, log_map
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import Matrix

_SCALE = ColourScale(-1.0, 1.0, DOUBLE)  # interference is orange, transfer blue


def log_matrix(root: Branch, matrix: Matrix, look: Look) -> None:
    """Draw a matrix; a dot marks a cell whose sign is in doubt.

    Args:
        root: where to.
        matrix: the cosines.
        look: colours and line widths.
    """
    chart = log_map(root, [matrix.axis, matrix.axis], matrix.value, _SCALE, look)
    place = np.argwhere(matrix.doubtful & np.isfinite(matrix.value))
    if len(place):
        across, up = matrix.axis.values[place.T]
        chart.dots("doubtful", across, up, look.colour("ground"), look.measured_width)
