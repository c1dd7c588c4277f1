"""Intervals of sums over windows that are correlated within blocks and within logs."""

import functools

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.blocks import Indices, blocks, logs
from dr_lab.trajectory import Array


def resampled(sums: Array, log: Indices, settings: EvidenceSettings) -> Array:
    """Sums over resampled blocks of windows, shape (rows, w) → (rows, resamples).

    Args:
        sums: what is summed, of each window.
        log: index of each window's log, shape (w,).
        settings: size and number of blocks, number of resamples.
    """
    parts = np.array([sums[:, b].sum(1) for b in blocks(log, settings.block, settings.least_blocks)])
    return (_drawn(len(parts), settings.gain_resamples, settings.seed) @ parts).T


def interval(
    estimate: float, resampled: Array, count: int, tail: float, settings: EvidenceSettings
) -> tuple[float, float]:
    """Interval of an estimate from its resamples over `count` blocks, beyond either end of which `tail` lies.

    The blocks, if few, show too little of their scatter, and that badly known, so the interval reaches to
    ±√(n/(n − 1)) t_{n−1} standard deviations. Its ends are percentiles of the resamples, as rare as that width asks
    for; where none is so rare, the resamples' standard deviation is taken. Of fewer than `settings.least_compared`
    blocks it is not known, NaN.

    Source: Hesterberg, The American Statistician 69 (2015) 371 (expanded percentiles).
    """
    if count < settings.least_compared:
        return np.nan, np.nan
    width = np.sqrt(count / (count - 1)) * student.isf(tail, count - 1)
    rare = norm.sf(width)
    if rare < 1 / len(resampled):
        half = width * resampled.std()
        return float(estimate - half), float(estimate + half)
    low, high = np.quantile(resampled, [rare, 1 - rare])
    return float(low), float(high)


def least_between_logs(values: Array, log: Indices, tail: float, settings: EvidenceSettings) -> float:
    """Lower bound of a sum over windows whose logs are clusters; ∞ where too few logs show their scatter.

    T − t_{n−1} √(n/(n − 1) Σ (T_k − w_k T / w)²), T_k being the sum over the w_k windows of log k, T over all w.

    Source: Cochran, Sampling Techniques, 1977, §9A.2 (clusters of unequal size).

    Args:
        values: of each window, shape (w,).
        log: index of each window's log, shape (w,).
        tail: probability that the sum that is to be expected lies below.
        settings: number of logs that are few.
    """
    groups = logs(log)
    count = len(groups)
    if count < settings.least_trusted:
        return np.inf
    total = float(values.sum())
    away = [float(values[rows].sum()) - total * len(rows) / len(values) for rows in groups]
    return total - float(student.isf(tail, count - 1) * np.sqrt(count / (count - 1)) * np.linalg.norm(away))


@functools.lru_cache(maxsize=4)
def _drawn(count: int, resamples: int, seed: int) -> Array:
    """How often each resample holds each of `count` blocks, shape (resamples, count)."""
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1 / count), resamples)
    return drawn.astype(np.float64)
