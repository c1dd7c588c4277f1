"""Uncertainty of a fitted context: formal, and from the scatter between logs."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.normal_equations import inverse_root
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.blocks import blocks, logs
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.trajectory import Array

_MIDDLE = (0.1587, 0.8413)  # one standard deviation to either side of a Gaussian's mean
_PART = 100  # resamples at a time; of an arm with 77 parameters, all of them at once take a gigabyte
_LEAST = 1e-300


def estimate(space: ContextSpace, fit: Fit, windows: Windows, settings: EvidenceSettings) -> ContextEstimate:
    """Mean and covariance of the fitted context.

    The covariance is the larger, direction by direction, of the formal one, I⁻¹, and of a block bootstrap over logs
    (one Gauss–Newton step per resample from the logs' own gradients), so that it covers logs that disagree and
    residuals that are coloured. A single log is resampled in blocks of consecutive windows instead.
    """
    formal = inverse_root(fit.equations.reduced.information, fit.equations.prior)
    span = np.diag(space.span)
    return ContextEstimate(space, fit.z, span @ _larger(formal, _scatter(fit, windows, settings)) @ span)


def clusters(windows: Windows, settings: EvidenceSettings) -> Sequence[NDArray[np.intp]]:
    """Rows of the windows of each log; of a single log, of each block."""
    groups = logs(windows.log)
    return groups if len(groups) > 1 else blocks(windows.log, settings.block, settings.least_blocks)


def per_log(space: ContextSpace, fit: Fit, windows: Windows) -> Array:
    """Context that each log alone would prefer, by one Gauss–Newton step from the common fit, shape (logs, n)."""
    information, gradient = _sums(fit, logs(windows.log))
    return space.clip(fit.z - _steps(fit, information, gradient) * space.span)


def per_log_std(space: ContextSpace, fit: Fit, windows: Windows) -> Array:
    """Formal standard deviations of these contexts, shape (logs, n)."""
    information, _ = _sums(fit, logs(windows.log))
    return np.linalg.norm(inverse_root(information, fit.equations.prior), axis=2) * space.span


def _sums(fit: Fit, groups: Sequence[NDArray[np.intp]]) -> tuple[Array, Array]:
    """Information and gradient of groups of windows, shapes (groups, n, n) and (groups, n)."""
    information, gradient = fit.equations.window_information()
    return np.array([information[g].sum(0) for g in groups]), np.array([gradient[g].sum(0) for g in groups])


def _scatter(fit: Fit, windows: Windows, settings: EvidenceSettings) -> Array:
    """Covariance of the contexts (unit cube) that resampled data prefer, shape (n, n); zero for a single block."""
    information, gradient = _sums(fit, clusters(windows, settings))
    count = len(gradient)
    if count == 1:
        return np.zeros_like(information[0])
    picks = np.random.default_rng(settings.seed).integers(0, count, (settings.resamples, count))
    parts = np.array_split(picks, -(-len(picks) // _PART))
    found = np.concatenate([_steps(fit, information[rows].sum(1), gradient[rows].sum(1)) for rows in parts])
    # Resampling n blocks shows only (n − 1)/n of their scatter.
    scatter = np.cov(found.T, ddof=1).reshape(information.shape[1:]) * count / (count - 1)
    # One step leads astray from resamples that lack the logs that tell a parameter; the middle 68 % tell the spread.
    middle = np.diff(np.quantile(found, _MIDDLE, axis=0), axis=0)[0] / 2
    ratio = np.minimum(middle / np.maximum(np.sqrt(np.diag(scatter)), _LEAST), 1.0)
    return scatter * np.outer(ratio, ratio)


def _steps(fit: Fit, information: Array, gradient: Array) -> Array:
    """(I + P)⁻¹ g of each resample, shape (k, n)."""
    root = inverse_root(information, fit.equations.prior)
    return (root @ (root.transpose(0, 2, 1) @ gradient[..., None]))[..., 0]


def _larger(root: Array, b: Array) -> Array:
    """Smallest covariance of a simple form that is at least a = R Rᵀ and at least `b` in every direction.

    In the coordinates in which a is the identity, each eigenvalue of b is raised to at least 1.
    """
    inverse = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(inverse @ b @ inverse.T)
    return root @ (vectors * np.maximum(values, 1.0)) @ vectors.T @ root.T
