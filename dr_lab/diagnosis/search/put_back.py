"""What is put back to a special case of it, and why: whether the logs ask for the richer of two effects."""

from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.likelihood import less_likely
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import paired_gain, supported, supported_within_logs
from dr_lab.diagnosis.settings import EvidenceSettings


@dataclass(frozen=True)
class PutBack:
    """An effect whose place one of its special cases has taken.

    Attributes:
        richer: its label.
        poorer: the special case's.
        further: value and standard deviation of the parameters that the special case lacks, by short names.
        compatible: whether these are compatible with zero, given the scatter between logs. Otherwise the effect was put
            back because the logs that score do not ask for them.
        certain: whether they differ from zero beyond doubt although few logs show their scatter badly.
        at_limit: whether they ended at their bounds next to zero, where the effect is the special case.
        little: whether they close little of the little that the poorer model leaves beyond the noise.
        hidden: whether the time step of the model does much of what they change.
    """

    richer: str
    poorer: str
    further: Mapping[str, tuple[float, float]]
    compatible: bool
    certain: bool
    at_limit: bool = False
    little: bool = False
    hidden: bool = False


def asked_for(poorer: FittedModel, richer: FittedModel, back: PutBack, extra: int, settings: EvidenceSettings) -> bool:
    """Whether the logs ask for the richer of two models, which has so many parameters more.

    They do not where its further parameters ended next to zero: what it gains there is by how it is computed. Else they
    do in two cases:

    1. The windows that score support it, and its further parameters differ from zero beyond doubt, given the scatter
       between logs. Where they do so even by F, which knows how few the logs are, the windows need not gain alike in
       all logs: a log that hardly excites the parameters gains little.
    2. It leaves noise, and the poorer one is less likely. Then it is no wrong model whose errors scatter from log to
       log. Where the poorer one leaves noise as well, the further parameters must also differ from zero as above.
    """
    if back.at_limit:
        return False
    if at_floor(richer.held_out, settings) and less_likely(poorer, richer, extra, settings):
        return not back.compatible or not at_floor(poorer.held_out, settings)
    gain, enough = paired_gain(poorer.held_out, richer.held_out, settings), supported
    if back.certain:
        enough = supported_within_logs
    return not back.compatible and enough(gain, extra, settings)


def closes_little(poorer: FittedModel, richer: FittedModel, settings: EvidenceSettings) -> bool:
    """Whether the richer of two models leaves most of a gap that hardly shows, in the channel with the most evidence.

    Of a gap g = χ² − 1 of the poorer model a cause closes the share `least_named`, s, or more. A model with the wrong
    law may close less, also beyond doubt: everything that is small and regular, such as the time step of another
    simulator, moves the parameters of some law away from zero. Where s g is more than what the noise is known to
    (`floor` − 1) the richer model shows itself whether it leaves noise. So only smaller gaps are asked.
    """
    gain = paired_gain(poorer.held_out, richer.held_out, settings)
    channel = poorer.held_out.channels.get(gain.place)
    gap = (poorer.held_out.chi2 if channel is None else channel.chi2) - 1
    hardly = settings.least_named * gap < settings.floor - 1
    return hardly and gain.channels.get(gain.place, 0.0) < settings.least_named
