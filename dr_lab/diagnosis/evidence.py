"""Does one model explain held-out windows better than another? Paired gains with a block bootstrap."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from dr_lab.diagnosis.blocks import blocks
from dr_lab.diagnosis.score import Score
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Gain:
    """How much lower one model's χ² is than another's, on the windows that both can simulate.

    Attributes:
        share: share of the worse model's χ² that the better one removes.
        low: lower end of its interval.
        high: upper end.
        gap: share of the worse model's χ² above the noise floor of 1 that the better one closes, the χ² of a model
            being exp(mean ln(1 + χ²_w)) − 1 over the windows; 1 where the worse one is at the floor.
        total: Σ_w 2 n_w ln((1 + χ²_w worse)/(1 + χ²_w better)), which is Δχ² near the noise floor and the
            log-likelihood ratio with an unknown error far above it; no single wild window decides.
        total_low: lower end of its interval; −∞ where the better model diverges in a window that the worse simulates.
        wins: share of windows in which the χ² is lower.
    """

    share: float
    low: float
    high: float
    gap: float
    total: float
    total_low: float
    wins: float


def paired_gain(worse: Score, better: Score, settings: EvidenceSettings) -> Gain:
    """Gain of `better` over `worse`, window by window.

    The intervals are percentile bootstraps over blocks of consecutive windows within logs, which keep the correlation
    of residuals inside a block.
    """
    both = (worse.window_count > 0) & (better.window_count > 0)
    if not both.any():
        return Gain(share=0.0, low=-np.inf, high=0.0, gap=0.0, total=0.0, total_low=-np.inf, wins=0.0)
    ours, theirs, count = better.window_sum[both], worse.window_sum[both], worse.window_count[both]
    evidence = 2 * count * np.log((1 + theirs / count) / (1 + ours / count))
    resampled = _resampled(np.stack([theirs, ours, evidence]), worse.log[both], settings)
    tail = 50 * (1 - settings.confidence)
    low, high = np.percentile(1 - resampled[1] / resampled[0], [tail, 100 - tail])
    diverges = ((worse.window_count > 0) & (better.window_count == 0)).any()
    before, after = (_typical(sums, count) for sums in (theirs, ours))
    return Gain(
        share=float((theirs - ours).sum() / theirs.sum()),
        low=float(low),
        high=float(high),
        gap=(before - after) / (before - 1) if before > 1 else 1.0,
        total=float(evidence.sum()),
        total_low=-np.inf if diverges else float(np.percentile(resampled[2], tail)),
        wins=float((theirs > ours).mean()),
    )


def _typical(sums: Array, count: Array) -> float:
    """χ² of a typical window."""
    return float(np.expm1((count * np.log1p(sums / count)).sum() / count.sum()))


def noise_floor(freedom: float, settings: EvidenceSettings) -> float:
    """Largest χ² per degree of freedom at which a model counts as right.

    The noise is known to `settings.floor`; on few samples, moreover, the χ² of a right model scatters, and exceeds this
    quantile of its distribution only with probability 1 − confidence.

    Args:
        freedom: degrees of freedom of the χ².
        settings: floor and confidence.
    """
    if freedom <= 0:
        return settings.floor
    return max(settings.floor, float(chi2.ppf(settings.confidence, freedom)) / freedom)


def supported(gain: Gain, extra_parameters: int, settings: EvidenceSettings) -> bool:
    """Whether a gain is beyond its interval, the threshold and the penalty of the added parameters, and no trifle."""
    enough = gain.total - settings.penalty * extra_parameters >= settings.threshold
    return gain.total_low > 0 and enough and gain.gap >= settings.least_gap


def _resampled(sums: Array, log: NDArray[np.intp], settings: EvidenceSettings) -> Array:
    """Sums over resampled blocks of windows, shape (rows, w) → (rows, resamples)."""
    parts = np.array([sums[:, b].sum(1) for b in blocks(log, settings.block, settings.least_blocks)])
    picks = np.random.default_rng(settings.seed).integers(0, len(parts), (settings.resamples, len(parts)))
    return parts[picks].sum(1).T
