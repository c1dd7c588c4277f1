"""Linear equations of windows' states, which an unstable simulation leaves singular to rounding."""

import numpy as np

from dr_lab.trajectory import Array

ROUNDING = 1e-13  # of eigenvalues, relative to the largest


def solved(equations: Array, right: Array) -> Array:
    """The solution x of A x = b with A = JᵀJ + P of every window.

    Where a simulation is unstable one state moves the end so far that the others are less than rounding beside it. So
    a share of the diagonal that is rounding is added to it.

    Args:
        equations: A, shape (w, s, s).
        right: b, shape (w, s, k).

    Returns:
        Shape (w, s, k).
    """
    firm = equations * (1.0 + ROUNDING * np.eye(equations.shape[-1]))
    return np.asarray(np.linalg.solve(firm, right), np.float64)
