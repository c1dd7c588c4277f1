"""A context with start states, and how well they fit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]
_USUAL = 0.9  # share of a window's samples that tells how large its residuals usually are; a glitch is shorter


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

    @property
    def order(self) -> tuple[int, float]:
        """What makes one fit of the same windows better than another: fewer that diverge, then a lower cost."""
        return int(self.infeasible.sum()), self.cost


def huber_weights(residuals: Array, fitted: Mask, infeasible: Mask, limit: float, channels: Sequence[slice]) -> Array:
    """Huber weights about a robust scale of each channel in each window, at least one noise standard deviation.

    The scale is that of a Gaussian of which as much lies within the size that nine tenths of the samples keep to. So
    a short glitch weighs little, while a window in which a wrong model strays weighs as much as any other: that is
    what a fit has to see. Unused samples weigh 0.

    Source: Huber, Annals of Mathematical Statistics 35 (1964) 73.

    Args:
        residuals: shape (w, m).
        fitted: samples that count, shape (w, m).
        infeasible: windows that are left out, shape (w,).
        limit: robust standard deviations beyond which a residual counts linearly.
        channels: columns of each channel.
    """
    used = fitted & ~infeasible[:, None]
    size = np.abs(residuals)
    bound = np.empty_like(size)
    for columns in channels:
        usual = _quantile(size[:, columns], used[:, columns]) / ndtri((1 + _USUAL) / 2)
        bound[:, columns] = limit * np.maximum(usual, 1.0)[:, None]
    return np.where(used, bound / np.maximum(size, bound), 0.0)


def _quantile(size: Array, used: Mask) -> Array:
    """The size that a usual share of the used samples keeps to, shape (w,); 0 where none is used."""
    if not size.shape[1]:
        return np.zeros(len(size))
    count = used.sum(1)
    place = np.maximum(np.ceil(_USUAL * count).astype(np.intp) - 1, 0)
    ordered = np.sort(np.where(used, size, np.inf), axis=1)
    return np.where(count > 0, np.take_along_axis(ordered, place[:, None], axis=1)[:, 0], 0.0)


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
