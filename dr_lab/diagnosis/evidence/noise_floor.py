"""Does what a model leaves pass for noise?"""

from math import inf

from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.fit.right_model import most_chi2
from dr_lab.diagnosis.settings import EvidenceSettings


def noise_floor(freedom: float, settings: EvidenceSettings) -> float:
    """Largest χ² per degree of freedom that is evidence of nothing; see `most_chi2`."""
    return most_chi2(freedom, settings.floor, settings.confidence)


def at_floor(score: Score, settings: EvidenceSettings) -> bool:
    """Whether what a model leaves passes for noise: as small as the noise of the logs, or such as instruments make.

    It does not where half of the windows diverge or more: what the others leave says nothing of most of the motion. A
    channel that leaves less than its noise makes up for no other: its noise is estimated too large.
    """
    if score.freedom <= 0 or 2 * score.infeasible >= len(score.window_count):
        return False
    if _chi2(score) <= noise_floor(score.freedom, settings):
        return True
    return bool(score.channels) and all(channel_at_floor(channel, settings) for channel in score.channels.values())


def _chi2(score: Score) -> float:
    """χ² per degree of freedom, where a channel counts as 1 at least: Σ_c n_c max(χ²_c, 1) / Σ_c n_c."""
    counts = {name: float(channel.window_count.sum()) for name, channel in score.channels.items()}
    total = sum(counts.values())
    if total <= 0 or score.chi2 == inf:
        return score.chi2
    return sum(counts[name] * max(channel.chi2, 1.0) for name, channel in score.channels.items()) / total


def alone_at_floor(model: Score, other: Score, settings: EvidenceSettings) -> bool:
    """Whether of two models only the first leaves what passes for noise.

    Then it is no wrong model whose errors scatter from log to log, and the likelihood says all.
    """
    return at_floor(model, settings) and not at_floor(other, settings)


def channel_at_floor(channel: ChannelScore, settings: EvidenceSettings) -> bool:
    """The same of one channel."""
    floor = noise_floor(float(channel.window_count.sum()) / channel.colour, settings)
    return channel.instrumental or channel.chi2 <= floor


def beyond_white(score: Score, settings: EvidenceSettings) -> bool:
    """Whether what passes for noise is larger than the sensors' white one, and is such as instruments make.

    Few residuals may also be larger by chance.
    """
    larger = score.chi2 > noise_floor(score.freedom, settings)
    return larger and any(channel.instrumental for channel in score.channels.values())


def at_coloured_floor(score: Score, settings: EvidenceSettings) -> bool:
    """Whether what a model leaves passes for noise, such as instruments make and larger than the white one."""
    return at_floor(score, settings) and beyond_white(score, settings)
