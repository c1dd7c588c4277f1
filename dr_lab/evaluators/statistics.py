"""What a few returns say: interquartile mean, its interval, who is better, means of contexts, the worst tenth."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import bootstrap, trim_mean
from scipy.stats import t as student

from dr_lab.reports.interval_level import FEWEST
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
        NaN throughout where nothing is known; the ends are NaN where fewer than `FEWEST` values are. Of few values the
        interval covers less than is asked for (`reports.interval_level.level`).
    """
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return Interval(np.nan, np.nan, np.nan)
    value, low, high = iqm_band(known[:, None], confidence, resamples, seed)
    return Interval(float(value[0]), float(low[0]), float(high[0]))


def improvement_interval(ours: Array, theirs: Array, confidence: float, resamples: int, seed: int) -> Interval:
    """Probability of improvement p = P(X > Y) + ½ P(X = Y), with an interval.

    X is one of our results, Y one of theirs. The estimate is U/(k m) of Mann and Whitney, the interval that of the
    percentile bootstrap, widened to an end that few results allow. For all of ours lie above all of theirs with
    probability p^n at most, n = min(k, m) independent pairs. Even then p may be as low as e, eⁿ = 1 − confidence, so
    that no lower end is above e, and no upper end below 1 − e; the bootstrap alone would say [1, 1].

    Source: Agarwal et al. 2021, "Deep RL at the edge of the statistical precipice", §4.3.

    Args:
        ours: independent results, shape (k,); NaN is left out.
        theirs: those of another method, shape (m,); likewise.
        confidence: of the interval, below 1.
        resamples: of the bootstrap, which draws from both.
        seed: of the bootstrap.

    Returns:
        NaN throughout where either has no result. The ends are NaN where results are so few that all of one method
        would lie above all of the other by chance, with probability 2/C(k+m, k), more often than the interval may err:
        a bootstrap of them would be sure.
    """
    ours, theirs = (values[np.isfinite(values)] for values in (ours, theirs))
    if min(len(ours), len(theirs)) == 0:
        return Interval(np.nan, np.nan, np.nan)
    value = float(_improvement(ours, theirs))
    if 2.0 / math.comb(len(ours) + len(theirs), len(ours)) > 1.0 - confidence:
        return Interval(value, np.nan, np.nan)
    rng, alpha = np.random.default_rng(seed), (1.0 - confidence) / 2.0
    drawn = [values[rng.integers(len(values), size=(resamples, len(values)))] for values in (ours, theirs)]
    low, high = np.quantile(_improvement(*drawn), [alpha, 1.0 - alpha])
    end = (1.0 - confidence) ** (1.0 / min(len(ours), len(theirs)))
    return Interval(value, min(float(low), end), max(float(high), 1.0 - end))


def mean_interval(values: Array, confidence: float, resamples: int, seed: int) -> Interval:
    """Mean of independent results (k,), one at least, with an interval as `iqm_interval` has it."""
    if len(values) < FEWEST:
        return Interval(float(values.mean()), np.nan, np.nan)
    rng, alpha = np.random.default_rng(seed), (1.0 - confidence) / 2.0
    drawn = rng.multinomial(len(values), np.full(len(values), 1.0 / len(values)), resamples) @ values / len(values)
    low, high = np.quantile(drawn, [alpha, 1.0 - alpha])
    return Interval(float(values.mean()), float(low), float(high))


def t_intervals(values: Array, confidence: float) -> tuple[Array, Array, Array]:
    """Means of few independent results with their intervals by Student's t, mean ± t s/√k.

    Args:
        values: shape (…, k); NaN is left out.
        confidence: of the intervals, below 1.

    Returns:
        Mean and the interval's ends, shape (…) each; NaN where nothing is known, the ends also where one value is.
    """
    known = np.isfinite(values)
    count = known.sum(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, values, 0.0).sum(axis=-1) / count
        square = np.where(known, np.square(values - mean[..., None]), 0.0).sum(axis=-1) / (count - 1)
        half = student.ppf(0.5 + 0.5 * confidence, count - 1) * np.sqrt(square / count)
    return mean, mean - half, mean + half


def iqm_band(values: Array, confidence: float, resamples: int, seed: int) -> tuple[Array, Array, Array]:
    """Interquartile mean of independent curves, point by point, with a percentile bootstrap interval.

    Args:
        values: independent curves, one at least, shape (k, n); where one is NaN, so is the result.
        confidence: of the interval, below 1.
        resamples: of the bootstrap, which takes whole curves.
        seed: of the bootstrap.

    Returns:
        The mean and the interval's ends, shape (n,) each; the ends are NaN where there are fewer than `FEWEST`
        curves.
    """
    known = np.isfinite(values).all(axis=0)
    value, low, high = (np.full(values.shape[1], np.nan) for _ in range(3))
    value[known] = interquartile_mean(values[:, known], axis=0)
    if len(values) < FEWEST or not known.any():
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


def _improvement(ours: Array, theirs: Array) -> Array:
    away = ours[..., :, None] - theirs[..., None, :]
    return (0.5 + 0.5 * np.sign(away)).mean(axis=(-2, -1))


def means_of_contexts(returns: Array, infeasible: NDArray[np.bool_]) -> Array:
    """Mean return in each context, shape (contexts,); NaN where all of its episodes are infeasible.

    Where some are, they count with what the policy got, which is the return that the environment declares for them:
    else a policy would look the better the more of its episodes diverge.

    Args:
        returns: undiscounted, shape (contexts, episodes).
        infeasible: whether an infeasible context ended the episode, shape (contexts, episodes).
    """
    return np.where(infeasible.all(axis=1), np.nan, returns.mean(axis=1))


def lower_tail(values: Array, share: float) -> float:
    """Mean of the lowest share α of k values, the conditional value at risk of their empirical distribution.

    CVaR_α = (Σ_{i ≤ ⌊αk⌋} x_(i) + (αk − ⌊αk⌋) x_(⌊αk⌋+1)) / αk, x_(i) in ascending order.

    Args:
        values: shape (k,); NaN is left out, and without any value is returned.
        share: α in (0, 1].

    Source: Rockafellar, Uryasev 2002, "Conditional value-at-risk for general loss distributions".
    """
    known = np.sort(values[np.isfinite(values)])
    if not len(known):
        return float("nan")
    weights = np.clip(share * len(known) - np.arange(len(known)), 0.0, 1.0)
    return float(weights @ known / weights.sum())
