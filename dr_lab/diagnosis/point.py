"""A context with start states, and how well they fit."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]
_MAD_TO_STD = 1.4826  # of a Gaussian


@dataclass(frozen=True)
class Point:
    """A context and start states, and how well they fit.

    Attributes:
        z: context, shape (n,).
        delta: corrections of the windows' initial states, shape (w, 2 nv).
        residuals: (measured − simulated)/σ, shape (w, m).
        cost: value of the robust cost, priors included; infinite where it is not known or a further window diverges.
        infeasible: windows whose simulation diverges; they are left out, shape (w,).
    """

    z: Array
    delta: Array
    residuals: Array
    cost: float
    infeasible: Mask


def huber_weights(residuals: Array, fitted: Mask, infeasible: Mask, limit: float) -> Array:
    """Huber weights about a robust scale of at least one noise standard deviation; 0 for unused samples.

    Args:
        residuals: shape (w, m).
        fitted: samples that count, shape (w, m).
        infeasible: windows that are left out, shape (w,).
        limit: robust standard deviations beyond which a residual counts linearly.
    """
    used = fitted & ~infeasible[:, None]
    size = np.abs(residuals)
    scale = max(1.0, _MAD_TO_STD * float(np.median(size[used]))) if used.any() else 1.0
    return np.where(used, limit * scale / np.maximum(size, limit * scale), 0.0)
