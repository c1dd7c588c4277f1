"""Commands through a driver that keeps one number from step to step."""

from collections.abc import Callable

import numpy as np

from dr_lab.trajectory import Array

Advance = Callable[[Array, Array], tuple[Array, Array]]
"""Output at a step's start and the step's command to the step's average output and the output at its end."""


def filtered(series: Array, contexts: int, advance: Advance) -> Array:
    """Step averages of a driver's output; at the first known command it is taken to be at rest.

    Args:
        series: step averages of the commands, shape (c or 1, w, s).
        contexts: c.
        advance: one step of all contexts and windows, on arrays of shape (c or 1, w).

    Returns:
        Step averages of the output, shape (c, w, s).
    """
    averages = np.empty((contexts, *series.shape[1:]))
    level = series[:, :, 0]
    for step in range(series.shape[2]):
        averages[:, :, step], level = advance(level, series[:, :, step])
    return averages
