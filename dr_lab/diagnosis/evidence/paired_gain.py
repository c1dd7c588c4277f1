"""Does one model explain windows that it did not see better than another? Paired gains with a block bootstrap."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from dr_lab.diagnosis.evidence.intervals import interval, least_between_logs, resampled
from dr_lab.diagnosis.evidence.noise_floor import alone_at_floor, at_coloured_floor, at_floor
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.evidence.typical import deviance, gap_closed, logs, typical
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.windows.blocks import Indices, blocks
from dr_lab.trajectory import Array

_LEAST = 1e-9  # χ²


@dataclass(frozen=True)
class Gain:
    """How much lower one model's χ² is than another's, on the windows that both can simulate.

    Attributes:
        share: share of the worse model's χ² that the better one removes in a typical window, of those that score and
            of fitted ones as fits to the others foretell them; χ² of a typical window is exp(mean ln(1 + χ²_w)) − 1.
        low, high: ends of its interval.
        error: share of the worse model's χ² that is more than noise, in a typical one of these windows.
        gap: share of the worse model's χ² above the noise floor of 1 that the better one closes in a typical window of
            those that score; where all channels together are at the floor, that of the channel `place`, 1 if it is too.
        channels: that share by channel, of those in which the worse model leaves more than noise.
        place: the channel in which the evidence of the windows that score is most.
        total: Σ (D worse − D better) over channels and windows, those that score and those that were fitted, these as
            fits to the others foretell them; the difference of the deviances −2 ln L of residuals that are noise or,
            where they are larger, errors of unknown size: D = n χ² up to χ² = 1 and n (1 + ln χ²) above, n being the
            number of independent ones among them. It is Δχ² near the noise floor, no single wild window decides far
            above it, and there it does not depend on how large the noise is.
        total_low: what it exceeds at the confidence asked for; −∞ where the better model diverges in a window that the
            worse simulates, NaN where there are too few blocks of data to know, or none that both simulate.
        trial_low: what it exceeds at the confidence of a trial; −∞ and NaN as above.
        blocks_low: as `total_low`, by the scatter between blocks alone, whatever that between logs is.
        logs_low: as `total_low`, by the scatter between logs, too, whatever makes it.
        wins: share of the windows that score in which the χ² is lower.
        clear: whether each of these gains, no window diverges that did not, and the better model alone is at the floor.
    """

    share: float
    low: float
    high: float
    error: float
    gap: float
    channels: Mapping[str, float]
    place: str
    total: float
    total_low: float
    trial_low: float
    blocks_low: float
    logs_low: float
    wins: float
    clear: bool


def _nothing(bound: float) -> Gain:
    """The gain where both models simulate no window; `bound` is the lower one of its evidence."""
    return Gain(0.0, -np.inf, 0.0, 0.0, 0.0, {}, "", 0.0, bound, bound, bound, bound, 0.0, clear=False)


def paired_gain(worse: Score, better: Score, settings: EvidenceSettings) -> Gain:
    """Gain of `better` over `worse`, window by window.

    The share with its interval and the evidence are summed over the windows that score and over those that were fitted,
    each block of which a fit to the others foretells (cross-validation): a few held-out windows alone tell little.

    The intervals are bootstraps over blocks of consecutive windows within logs, which keep the correlation of residuals
    inside a block; below `settings.least_compared` blocks they are not known. Of the evidence's bound see `_bounds`.

    Source: Davison and Hinkley, Bootstrap Methods and their Application, 1997, §8.2 (blocks), §3.8 (clusters).
    """
    both = (worse.window_count > 0) & (better.window_count > 0)
    if not both.any():
        return _nothing(-np.inf if _diverges(worse, better) else np.nan)
    ours, theirs, count = better.window_sum[both], worse.window_sum[both], worse.window_count[both]
    each = {name: _one_channel(*pair, both) for name, pair in _paired(worse, better).items()}
    place = max(each, key=lambda name: float(each[name][0].sum()))
    every = _everywhere(np.sum([found[0] for found in each.values()], axis=0), worse, better, both)
    drawn, n = resampled(every.rows, every.log, settings), block_count(every.log, settings)
    share = float(_removed(every.rows.sum(1)))
    low, high = interval(share, _removed(drawn), n, (1 - settings.confidence) / 2, settings)
    gaps = {name: gap for name, (_, gap) in each.items() if not np.isnan(gap)}
    unequal = _moved_unequally(better, gaps.get(place, 0.0), settings)
    bounds = _bounds(every, drawn[3], (worse, better), settings, within=unequal)
    return Gain(
        share=share,
        low=low,
        high=float(np.minimum(high, 1.0)),
        error=max(1 - 1 / max(_typical_of(every.rows.sum(1))[0], _LEAST), 0.0),
        gap=gap_closed(theirs, ours, count, gaps.get(place, 1.0)),
        channels=gaps,
        place=place,
        total=float(every.rows[3].sum()),
        total_low=bounds.total,
        trial_low=bounds.trial,
        blocks_low=bounds.blocks,
        logs_low=bounds.logs,
        wins=float((theirs > ours).mean()),
        clear=bool((theirs > ours).all() and not _diverges(worse, better)) and alone_at_floor(better, worse, settings),
    )


def _diverges(worse: Score, better: Score) -> bool:
    """Whether the better model lets a window diverge that the worse one simulates, among all windows."""
    pairs = [(worse, better), (worse.foretold, better.foretold)]
    known = [(first, second) for first, second in pairs if first is not None and second is not None]
    return any(bool(((first.window_count > 0) & (second.window_count == 0)).any()) for first, second in known)


class _Every(NamedTuple):
    """All windows, those that score before those that were fitted.

    Attributes:
        rows: Σ n ln(1 + χ²) of the worse and the better model, n and the evidence of each window, shape (4, w).
        log: index of each window's log, shape (w,).
    """

    rows: Array
    log: Indices


def _everywhere(evidence: Array, worse: Score, better: Score, both: NDArray[np.bool_]) -> _Every:
    """All windows; `evidence` is that of the windows that score, shape (w,)."""
    scoring, log = _rows(evidence, worse, better, both), worse.log[both]
    if worse.foretold is None or better.foretold is None:
        return _Every(scoring, log)
    before, after = worse.foretold, better.foretold
    known = (before.window_count > 0) & (after.window_count > 0)
    further = np.sum([_one_channel(*pair, known)[0] for pair in _paired(before, after).values()], axis=0)
    rows = np.append(scoring, _rows(further, before, after, known), axis=1)
    return _Every(rows, np.append(log, before.log[known] + log.max(initial=0) + 1))


class _Bounds(NamedTuple):
    """Lower bounds of the evidence: the one that counts, of a trial, by blocks alone, and by logs, too."""

    total: float
    trial: float
    blocks: float
    logs: float


def _moved_unequally(better: Score, closed: float, settings: EvidenceSettings) -> bool:
    """Whether logs that gain unequally tell how the machine moved in each, and of no errors alike all over a log.

    It is so where the better model leaves noise, so that it has no such errors, and either that is more than white
    noise, such as instruments make, beside which small errors do not show, or it closes a share `settings.least_named`
    of the gap in the channel with the most evidence: errors that some effect's parameters take up leave more.
    """
    most = at_floor(better, settings) and closed >= settings.least_named
    return most or at_coloured_floor(better, settings)


def _bounds(
    every: _Every, drawn: Array, scores: tuple[Score, Score], settings: EvidenceSettings, *, within: bool
) -> _Bounds:
    """The bounds; −∞ where only the better model lets windows diverge.

    Errors of a model may be alike all over a log. So the bound is the lower one of two: that of the blocks, and, of
    `settings.least_clusters` logs or more, that of the logs as clusters, fitted ones among them; that of the blocks
    alone where logs gain unequally for another reason (`within`; see `_moved_unequally`). Below it lies what the better
    model's further parameters may cost as they happen to be fitted (`_loss`).
    """
    if _diverges(*scores):
        return _Bounds(-np.inf, -np.inf, -np.inf, -np.inf)
    (blocks, between), trials = (
        _lowest(every, drawn, 1 - c, scores, settings) for c in (settings.confidence, settings.trial_confidence)
    )
    counts = (blocks, trials[0]) if within else (between, trials[1])
    return _Bounds(*counts, blocks, between)


def _lowest(
    every: _Every, drawn: Array, tail: float, scores: tuple[Score, Score], settings: EvidenceSettings
) -> tuple[float, float]:
    """Lower bounds of the evidence: by the scatter between blocks, and by that or the scatter between logs.

    The distance from the estimate and the loss, which are independent, add up as roots of squares do.
    """
    total, loss = float(every.rows[3].sum()), _loss(*scores, tail)
    blocks = interval(total, drawn, block_count(every.log, settings), tail, settings)[0]
    clusters = least_between_logs(every.rows[3], every.log, tail, settings)
    # Too few blocks leave no bound, whatever the logs say: Python's min would drop a NaN in second place.
    within, both = (total - float(np.hypot(total - low, loss)) for low in (blocks, np.minimum(blocks, clusters)))
    return within, both


def _loss(worse: Score, better: Score, tail: float) -> float:
    """How much more evidence than on average the better model's p further parameters may cost, as they were fitted.

    Noise moves them away from what is best for all logs alike. Over as many windows as were fitted that costs Δχ² of
    mean p, χ²_p distributed, and r times as much over r times as many. The scatter between windows does not show by how
    much the fit at hand differs from the mean: r (χ²_p(1 − tail) − p).

    Source: Wilks, Annals of Mathematical Statistics 9 (1938) 60.
    """
    more = better.parameters - worse.parameters
    if more <= 0:
        return 0.0
    fitted = better.foretold.freedom if better.foretold is not None else 0.0
    ratio = 1 + better.freedom / fitted if fitted > 0 else 1.0
    return ratio * (float(chi2.isf(tail, more)) - more)


def _rows(evidence: Array, worse: Score, better: Score, both: NDArray[np.bool_]) -> Array:
    n = worse.window_count[both]
    return np.stack([logs(worse.window_sum[both], n), logs(better.window_sum[both], n), n, evidence])


def _removed(sums: Array) -> Array:
    """Share of a typical window's χ² that the better model removes, from sums of rows of `_Every`."""
    before, after = _typical_of(sums)
    return 1 - after / np.maximum(before, _LEAST)


def _typical_of(sums: Array) -> Array:
    """χ² of both models in a typical window, from sums of rows of `_Every`."""
    return typical(sums[:2], sums[2])


def block_count(log: Indices, settings: EvidenceSettings) -> int:
    """Number of blocks that windows make, `log` being the index of each window's log, shape (w,)."""
    return len(blocks(log, settings.block, settings.least_blocks))


def _paired(worse: Score, better: Score) -> dict[str, tuple[ChannelScore, ChannelScore]]:
    """Both models' channels; all residuals as one channel where they are not told apart."""
    if worse.channels and better.channels:
        return {name: (worse.channels[name], better.channels[name]) for name in worse.channels}
    first, second = (ChannelScore(s.window_sum, s.window_count, 1.0, instrumental=False) for s in (worse, better))
    return {"": (first, second)}


def _one_channel(worse: ChannelScore, better: ChannelScore, both: NDArray[np.bool_]) -> tuple[Array, float]:
    """Evidence of each window, and the share of the gap that closes.

    How many residuals are independent is read from those of the model that leaves less: what the other one leaves is
    also coloured by what it lacks.
    """
    ours, theirs, count = better.window_sum[both], worse.window_sum[both], worse.window_count[both]
    least = better if better.chi2 <= worse.chi2 else worse
    return (deviance(theirs, count) - deviance(ours, count)) / least.colour, gap_closed(theirs, ours, count, np.nan)
