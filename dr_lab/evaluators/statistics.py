"""What a few returns say: interquartile mean, its interval, the worst tenth."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import bootstrap, trim_mean

from dr_lab.trajectory import Array

_BATCH = 100  # resamples at a time, which bounds the memory that long curves take


@dataclass(frozen=True)
class Interval:
    """An estimate with its interval.

    Attributes:
        value: the estimate.
        low: lower end.
        high: upper end.
    """

    value: float
    low: float
    high: float


def interquartile_mean(values: Array, axis: int = -1) -> Array:
    """Mean of the middle half (Agarwal et al. 2021, "Deep RL at the edge of the statistical precipice")."""
    return np.asarray(trim_mean(values, 0.25, axis=axis))


def iqm_interval(values: Array, confidence: float, resamples: int, seed: int) -> Interval:
    """Interquartile mean with a percentile bootstrap interval.

    Args:
        values: independent results, shape (k,); NaN is left out.
        confidence: of the interval, below 1.
        resamples: of the bootstrap.
        seed: of the bootstrap.

    Returns:
        NaN throughout where nothing is known; where fewer than two values are, the ends are NaN.
    """
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return Interval(np.nan, np.nan, np.nan)
    value, low, high = iqm_band(known[:, None], confidence, resamples, seed)
    return Interval(float(value[0]), float(low[0]), float(high[0]))


def iqm_band(values: Array, confidence: float, resamples: int, seed: int) -> tuple[Array, Array, Array]:
    """Interquartile mean of independent curves, point by point, with a percentile bootstrap interval.

    Args:
        values: independent curves, one at least, shape (k, n); where one is NaN, so is the result.
        confidence: of the interval, below 1.
        resamples: of the bootstrap, which takes whole curves.
        seed: of the bootstrap.

    Returns:
        The mean and the interval's ends, shape (n,) each; the ends are NaN where there is but one curve.
    """
    known = np.isfinite(values).all(axis=0)
    value, low, high = (np.full(values.shape[1], np.nan) for _ in range(3))
    value[known] = interquartile_mean(values[:, known], axis=0)
    if len(values) < 2 or not known.any():
        return value, low, high
    found = bootstrap(
        (values[:, known],),
        interquartile_mean,
        axis=0,
        n_resamples=resamples,
        batch=_BATCH,
        confidence_level=confidence,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    low[known], high[known] = found.low, found.high
    return value, low, high


def worst_decile(values: Array) -> float:
    """Mean of the worst tenth, one value at least; NaN is left out, and without any value is returned."""
    known = np.sort(values[np.isfinite(values)])
    return float(known[: max(1, len(known) // 10)].mean()) if len(known) else float("nan")
