"""The verdict on one ranking (named, equivalent, not excited, none, unexplained) and the status of each candidate."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isnan

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.likelihood import less_likely
from dr_lab.diagnosis.evidence.noise_floor import at_floor, beyond_white, noise_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.support import largest_gap, sizeable, supported, worth_a_trial
from dr_lab.diagnosis.search.as_special_case import holds
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.wider import ran_into
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.effect import FAMILIES
from dr_lab.effects.periodic import PERIODS
from dr_lab.reports.quantity import number, percent


@dataclass(frozen=True)
class Verdict:
    """What a ranking says of the missing effect.

    Attributes:
        kind: ``named`` (one effect at one site beats all others), ``equivalent`` (several that the data cannot
            separate), ``not_excited`` (the model is at the noise floor, and of no effect would the data show anything),
            ``none`` (nothing supported, the model is at the noise floor) or ``unexplained`` (nothing supported
            although a gap remains).
        effects: labels of the named or equivalent effects, the one nearest to a joint first.
        status: label → ``named``, ``equivalent``, ``not_excited``, ``not_needed`` (it explains about as much as what is
            named or equivalent, with more parameters) or ``rejected``.
        trial: labels of the effects that pass at the lower confidence of a trial, in the same order; only where none is
            named although a gap remains. Later effects may put the first of them beyond doubt.
        absorbed: labels of effects whose place the model's own free parameters can take on these data.
        reason: one sentence.
    """

    kind: str
    effects: tuple[str, ...]
    status: Mapping[str, str]
    trial: tuple[str, ...]
    absorbed: tuple[str, ...]
    reason: str

    def put_back(self, richer: str, poorer: str) -> "Verdict":
        """The verdict where a special case has taken the place of one of its effects; itself where it has neither."""
        if richer not in self.effects or poorer not in self.status:
            return self
        effects = dict.fromkeys(poorer if label == richer else label for label in self.effects)
        return replace(
            self, effects=tuple(effects), status={**self.status, poorer: self.status[richer], richer: "not_needed"}
        )


def decide(
    base: FittedModel, ranking: Sequence[Candidate], settings: EvidenceSettings, scored: str = "held-out logs"
) -> Verdict:
    """Judge a ranking, most evidence first.

    Of the candidates that the evidence supports these stand, and the data cannot separate them:

    1. The best one and those that it does not beat beyond doubt form a group.
    2. Of the group those stand that no poorer one makes needless. A richer effect that explains little more, or that
       holds the poorer one as a special case, is no rival.
    3. If the best one does not stand, those join that no standing one beats.

    Args:
        base: the model without them.
        ranking: the candidates.
        settings: when a gain counts.
        scored: the logs that the scores are from, in words.
    """
    helpful = [c for c in ranking if c.final and c.resolved and _explains_enough(c, settings)]
    group = _inseparable([c for c in helpful if _passes(supported, c, settings)], settings)
    absorbed = tuple(c.effect.label for c in ranking if c not in group and _absorbed(c, settings))
    status = {c.effect.label: _status(c, group, absorbed, settings) for c in ranking}
    status |= {c.effect.label: "not_needed" for c in ranking if c not in group and _as_good(c, group, settings)}
    labels = tuple(c.effect.label for c in group)
    kind = _kind(base, group, status, settings)
    doubtful = [c for c in helpful if kind == "unexplained" and _passes(worth_a_trial, c, settings)]
    trial = _inseparable(doubtful, settings)
    near = helpful[:1] if kind == "unexplained" and not trial else []
    reason = (
        _reason(kind, base, group, status, settings, scored)
        + _prospect(trial, settings)
        + _nearest(base, near, settings)
    )
    return Verdict(kind, labels, status, tuple(c.effect.label for c in trial), absorbed, reason)


def _explains_enough(candidate: Candidate, settings: EvidenceSettings) -> bool:
    """Whether a candidate explains a fair part of the gap: far above the noise floor many effects help a little.

    Coloured noise of the instruments is no gap, of which an effect could explain a part. Where nothing else is left in
    the channel with the most evidence, the evidence decides alone. One that is bent as far as its bounds allow, and
    leaves more than noise, stands for another law: it must explain most of the gap.
    """
    channel = candidate.fitted_model.held_out.channels.get(candidate.gain.place)
    coloured = channel is not None and channel.instrumental and channel.chi2 > settings.floor
    closed = largest_gap(candidate.gain)
    if coloured or not settings.least_explained <= closed < settings.least_named:
        return coloured or closed >= settings.least_named
    return at_floor(candidate.fitted_model.held_out, settings) or not _bent(candidate)


def _bent(candidate: Candidate) -> bool:
    """Whether its number of periods, or more than one parameter, ended at a bound where it is itself.

    There a cogging has less than half a period where the joint moves, and stands for any smooth force. At its lower
    bound a shape that may get sharper makes an effect one of its special cases.
    """
    placed, values = candidate.effect, candidate.fitted_model.values()
    sharper = {f"{placed.label}.{name}" for name in placed.effect.sharpened}
    ends = ((p.name, ran_into(p, values[p.name])) for p in placed.parameters)
    ended = {name for name, (low, high) in ends if high or (low and name not in sharper)}
    return len(ended) > 1 or f"{placed.label}.{PERIODS}" in ended


def _passes(
    asked: Callable[[Gain, int, EvidenceSettings], bool], candidate: Candidate, settings: EvidenceSettings
) -> bool:
    return asked(candidate.gain, len(candidate.effect.parameters), settings)


def _kind(base: FittedModel, group: Sequence[Candidate], status: Mapping[str, str], settings: EvidenceSettings) -> str:
    if group:
        return "named" if len(group) == 1 else "equivalent"
    if not at_floor(base.held_out, settings):
        return "unexplained"
    return "not_excited" if status and set(status.values()) == {"not_excited"} else "none"


def _reason(
    kind: str,
    base: FittedModel,
    group: Sequence[Candidate],
    status: Mapping[str, str],
    settings: EvidenceSettings,
    scored: str,
) -> str:
    """The verdict in words, with the figures that it rests on."""
    labels = ", ".join(c.effect.label for c in group)
    if kind == "named":
        return f"{labels} {_worth(base, group[0], settings)} on the {scored}, beyond every other candidate."
    if kind == "equivalent":
        left = ", ".join(f"{c.effect.label} (mean χ² {number(c.fitted_model.held_out.chi2)})" for c in group)
        return f"The {scored} cannot separate {left}: what one explains better than another is not beyond doubt."
    floor = noise_floor(base.held_out.freedom, settings)
    coloured = beyond_white(base.held_out, settings)
    place = "at the floor of the sensors' coloured noise" if coloured else "at the noise floor"
    place = f"above the noise floor of {floor:.3g}" if kind == "unexplained" else place
    lost, every = base.held_out.infeasible, len(base.held_out.window_count)
    mean = (
        f"mean χ² {number(base.held_out.chi2)} on the {scored}{f', {lost} of {every} windows diverge' if lost else ''}"
    )
    told = f"The model is {place} ({mean}). No effect of the catalogue lowers that beyond doubt."
    silent = ", ".join(label for label, each in status.items() if each == "not_excited")
    return f"{told} Even at their bounds these effects would not show in the logs: {silent}." if silent else told


def _prospect(trial: Sequence[Candidate], settings: EvidenceSettings) -> str:
    """What is worth a trial, in words."""
    if not trial:
        return ""
    gain, confidence = trial[0].gain, 100 * settings.trial_confidence
    return (
        f" {trial[0].effect.label} is worth a trial, which dr-lab close makes as far as `most` allows. It closes "
        f"{percent(gain.gap)} of a typical window's gap. Its evidence Δχ² {number(gain.total)} is in doubt because "
        f"it differs from window to window ({confidence:.3g} % interval from {number(gain.trial_low)}, "
        f"{100 * settings.confidence:.3g} % interval from {number(gain.total_low)})."
    )


def _nearest(base: FittedModel, near: Sequence[Candidate], settings: EvidenceSettings) -> str:
    """What explains most though the evidence for it is too weak, in words."""
    if not near:
        return ""
    worth = _worth(base, near[0], settings)
    return f" {near[0].effect.label} comes nearest. It {worth} which is not beyond doubt: record more."


def _worth(base: FittedModel, candidate: Candidate, settings: EvidenceSettings) -> str:
    """The evidence, which decides for a candidate, and the mean χ², on which a single wild window weighs more."""
    gain, means = candidate.gain, (base.held_out.chi2, candidate.fitted_model.held_out.chi2)
    needed = settings.threshold + settings.penalty * len(candidate.effect.parameters)
    low = f"{100 * settings.confidence:.3g} % interval from {number(gain.total_low)}"
    interval = f"{'too few data for an interval' if isnan(gain.total_low) else low}, {needed:g} needed"
    return (
        f"closes {percent(gain.gap)} of a typical window's gap with evidence Δχ² {number(gain.total)} ({interval}), "
        f"mean χ² {number(means[0])} before and {number(means[1])} after,"
    )


def _inseparable(backed: Sequence[Candidate], settings: EvidenceSettings) -> list[Candidate]:
    """The candidates that the data cannot separate, as `decide` says.

    Those that join because the best one is needlessly rich displace none of the group. The one nearest to a joint comes
    first.
    """
    if not backed:
        return []
    best = backed[0]
    group = [best, *(c for c in backed[1:] if not _beats(best, c, settings))]
    kept = _needed(group, settings)
    if best not in kept:
        others = [c for c in backed if c not in group and not any(_beats(k, c, settings) for k in kept)]
        needed = _needed([*kept, *others], settings)
        kept = [*kept, *(c for c in others if c in needed)]
    return sorted(kept, key=_nearness)


def _beats(candidate: Candidate, other: Candidate, settings: EvidenceSettings) -> bool:
    gain = paired_gain(other.fitted_model.held_out, candidate.fitted_model.held_out, settings)
    return supported(gain, 0, settings)


def _needed(group: list[Candidate], settings: EvidenceSettings) -> list[Candidate]:
    """Those of the candidates that are as likely as any which no poorer one makes needless."""
    group = _likeliest(group, settings)
    return [c for c in group if not any(_needless(c, other, settings) for other in group)]


def _needless(candidate: Candidate, other: Candidate, settings: EvidenceSettings) -> bool:
    """Whether a candidate has more parameters than another one and explains little more.

    One that holds the other as a special case is needless whatever it explains: `pruning` weighs it against that.
    """
    extra = len(candidate.effect.parameters) - len(other.effect.parameters)
    if extra <= 0 or holds(candidate.effect, other.effect):
        return extra > 0
    gain = paired_gain(other.fitted_model.held_out, candidate.fitted_model.held_out, settings)
    return not sizeable(gain, extra, settings)


def _likeliest(group: list[Candidate], settings: EvidenceSettings) -> list[Candidate]:
    """The most likely candidates if one of the group leaves noise alone; otherwise the whole group.

    At the noise floor Δχ² is the likelihood ratio. The fitted logs contribute to it as well, and it needs no interval,
    which would be wide for few blocks of data. Above the floor the models are wrong in ways that differ from log to
    log, and the intervals decide.
    """
    if not any(at_floor(c.fitted_model.held_out, settings) for c in group):
        return group
    likeliest = [c for c in group if not any(_less_likely(c, other, settings) for other in group)]
    # If one diverges, pairs are compared in different windows, and each can lose to another. Then all winners stay.
    return likeliest or [c for c in group if any(_less_likely(other, c, settings) for other in group)]


def _less_likely(candidate: Candidate, other: Candidate, settings: EvidenceSettings) -> bool:
    extra = len(other.effect.parameters) - len(candidate.effect.parameters)
    return less_likely(candidate.fitted_model, other.fitted_model, extra, settings)


def _nearness(candidate: Candidate) -> tuple[int, float]:
    """Order among inseparable effects: the catalogue's families, from the joint outwards, then held-out χ²."""
    return FAMILIES.index(candidate.effect.effect.family), candidate.fitted_model.held_out.chi2


def _absorbed(candidate: Candidate, settings: EvidenceSettings) -> bool:
    """Whether the model's own parameters take its place, by a linear step; a fit that gains much shows otherwise."""
    known = candidate.identifiability
    gain = candidate.gain
    moved = candidate.fitted and gain.total >= settings.threshold and largest_gap(gain) >= settings.least_named
    excited = known.alone >= settings.threshold and not moved
    return excited and (known.share < settings.absorbed or known.beside < settings.threshold)


def _as_good(candidate: Candidate, group: Sequence[Candidate], settings: EvidenceSettings) -> bool:
    """Whether a candidate explains about as much as one of those that stand, with more parameters."""
    if not candidate.final:
        return candidate.needless and bool(group)
    return _passes(supported, candidate, settings) and any(
        len(candidate.effect.parameters) > len(stands.effect.parameters) and not _beats(stands, candidate, settings)
        for stands in group
    )


def _status(
    candidate: Candidate, group: Sequence[Candidate], absorbed: Sequence[str], settings: EvidenceSettings
) -> str:
    if candidate in group:
        return "named" if len(group) == 1 else "equivalent"
    if candidate.identifiability.alone < settings.threshold:
        return "not_excited"
    gains = candidate.gain.low > 0  # False if the data are too few for an interval
    return "equivalent" if candidate.effect.label in absorbed and not gains else "rejected"
