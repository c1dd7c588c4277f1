"""A context with start states, and how well they fit."""

from dataclasses import dataclass, replace

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
        delta: corrections of the windows' initial states, shape (w, nstate).
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


def window_costs(point: Point, weight: Array, precision: Array) -> Array:
    """Robust cost of every window with its prior, shape (w,).

    Args:
        point: residuals and state corrections.
        weight: Huber weights, shape (w, m).
        precision: of the prior, shape (nstate,).
    """
    return (weight * point.residuals**2).sum(1) + (precision * point.delta**2).sum(1)


def take(point: Point, other: Point, chosen: Mask) -> Point:
    """The point with states and residuals of the other in the chosen windows, shape (w,)."""
    rows = chosen[:, None]
    return replace(
        point,
        delta=np.where(rows, other.delta, point.delta),
        residuals=np.where(rows, other.residuals, point.residuals),
    )


def better_start(mean: Point, near: Point, weight: Array, precision: Array) -> Point:
    """In each window the prior's mean, or states from nearby where they fit better; of one context.

    States that made up for what another model lacks may lie behind a barrier from the best ones.

    Args:
        mean: the prior's mean in every window.
        near: states that were fitted under another model or context.
        weight: Huber weights, shape (w, m).
        precision: of the prior, shape (nstate,).
    """
    worse = window_costs(mean, weight, precision) > window_costs(near, weight, precision)
    chosen = (mean.infeasible | worse) & ~near.infeasible
    return replace(take(mean, near, chosen), infeasible=mean.infeasible & ~chosen)
