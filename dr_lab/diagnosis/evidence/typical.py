"""What windows leave, so that no wild one decides: their deviance, and the χ² of a typical one."""

import numpy as np

from dr_lab.trajectory import Array

_LEAST = 1e-9  # degrees of freedom; a window without samples of a channel has none


def deviance(sums: Array, count: Array) -> Array:
    """−2 ln L of each window, but for a constant, at the likeliest variance of at least the noise's.

    Args:
        sums: of the squares of each window's residuals, in standard deviations of the noise, shape (w,).
        count: number of these, shape (w,).
    """
    level = sums / np.maximum(count, _LEAST)
    return count * np.where(level > 1, 1 + np.log(np.maximum(level, 1)), level)


def logs(sums: Array, count: Array) -> Array:
    """N ln(1 + χ²) of each window; arguments as for `deviance`."""
    return count * np.log1p(sums / np.maximum(count, _LEAST))


def typical(logs: Array, count: Array) -> Array:
    """χ² of a typical window, exp(mean ln(1 + χ²_w)) − 1, from sums of `logs` and of counts, shape (...,)."""
    return np.expm1(logs / np.maximum(count, _LEAST))


def gap_closed(worse: Array, better: Array, count: Array, none: float) -> float:
    """Share of the gap χ² − 1 of a typical window that closes; `none` where there is no gap.

    Args:
        worse: sums of the squares of each window's residuals by the model that leaves the gap, shape (w,).
        better: the same by the other one.
        count: number of residuals, shape (w,).
        none: what is returned where noise is all that the worse model leaves.
    """
    before, after = (float(typical(logs(sums, count).sum(), count.sum())) for sums in (worse, better))
    return min((before - after) / (before - 1), 1.0) if before > 1 else none
