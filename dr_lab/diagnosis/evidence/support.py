"""When the gain of one model over another counts."""

from dr_lab.diagnosis.evidence.noise_floor import channel_at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain
from dr_lab.diagnosis.evidence.score import Score
from dr_lab.diagnosis.settings import EvidenceSettings


def largest_gap(gain: Gain) -> float:
    """Share of the gap that closes, over all channels or in the one with most evidence, if it has a gap, at best."""
    return max(gain.gap, gain.channels.get(gain.place, 0.0))


def cleared(worse: Score, better: Score, gain: Gain, settings: EvidenceSettings) -> bool:
    """Whether the channel with the most evidence comes down to the noise floor from above it."""
    pair = (score.channels.get(gain.place) for score in (worse, better))
    before, after = (channel is not None and channel_at_floor(channel, settings) for channel in pair)
    return after and not before


def supported(gain: Gain, extra_parameters: int, settings: EvidenceSettings) -> bool:
    """Whether a gain is beyond its interval, threshold and penalty, and no trifle.

    A typical window gains, too, where that is known. With few blocks the evidence may have no bound above 0. None is
    asked of a model at the noise floor, where it is a likelihood ratio, that gains in every window that scores.
    """
    return not gain.low <= 0 and certain(gain, settings) and sizeable(gain, extra_parameters, settings)


def supported_within_logs(gain: Gain, extra_parameters: int, settings: EvidenceSettings) -> bool:
    """The same where logs may gain unequally, because another test holds the scatter between logs."""
    return _beyond(gain, gain.blocks_low, settings) and sizeable(gain, extra_parameters, settings)


def supported_in_all_logs(gain: Gain, extra_parameters: int, settings: EvidenceSettings) -> bool:
    """The same where logs may not gain unequally, whatever makes it: what tells one law from its special case."""
    beyond = _beyond(gain, gain.logs_low, settings)
    return not gain.low <= 0 and beyond and sizeable(gain, extra_parameters, settings)


def certain(gain: Gain, settings: EvidenceSettings) -> bool:
    """Whether a gain is beyond its interval, however small; of intervals see `supported`."""
    return _beyond(gain, gain.total_low, settings)


def _beyond(gain: Gain, low: float, settings: EvidenceSettings) -> bool:
    return low > 0 or bool(gain.clear and gain.gap >= settings.least_named and not gain.low <= 0)


def worth_a_trial(gain: Gain, extra_parameters: int, settings: EvidenceSettings) -> bool:
    """Whether a gain is supported but for its interval, of which only the confidence of a trial is asked.

    Where several effects are missing each scatters what another one gains. Of one that closes half of a typical
    window's gap no interval is asked: no other cause can explain as much.
    """
    return (gain.trial_low > 0 or gain.gap >= settings.least_named) and sizeable(gain, extra_parameters, settings)


def sizeable(gain: Gain, extra_parameters: int, settings: EvidenceSettings) -> bool:
    """Whether a gain, if certain, is beyond the threshold and the penalty of the added parameters, and no trifle."""
    enough = gain.total - settings.penalty * extra_parameters >= settings.threshold
    return enough and largest_gap(gain) >= settings.least_gap
