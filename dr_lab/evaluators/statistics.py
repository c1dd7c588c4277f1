"""What a few returns say: interquartile mean, its interval, the worst tenth."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import bootstrap, trim_mean

from dr_lab.trajectory import Array


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
    value = float(interquartile_mean(known))
    if len(known) < 2:
        return Interval(value, np.nan, np.nan)
    found = bootstrap(
        (known,),
        interquartile_mean,
        n_resamples=resamples,
        confidence_level=confidence,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return Interval(value, float(found.low), float(found.high))


def worst_decile(values: Array) -> float:
    """Mean of the worst tenth, one value at least; NaN is left out, and without any value is returned."""
    known = np.sort(values[np.isfinite(values)])
    return float(known[: max(1, len(known) // 10)].mean()) if len(known) else float("nan")
