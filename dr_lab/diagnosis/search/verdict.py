"""The verdict on one ranking (named, equivalent, not excited, none, unexplained) and the status of each candidate."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.paired_gain import (
    Gain,
    at_floor,
    largest_gap,
    noise_floor,
    paired_gain,
    sizeable,
    supported,
    worth_a_trial,
)
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.effect import FAMILIES


@dataclass(frozen=True)
class Verdict:
    """What a ranking says of the missing effect.

    Attributes:
        kind: ``named`` (one effect at one site beats all others), ``equivalent`` (several that the data cannot
            separate), ``not_excited`` (the model is at the noise floor, and of no effect would the data show anything),
            ``none`` (nothing supported, the model is at the noise floor) or ``unexplained`` (nothing supported
            although a gap remains).
        effects: labels of the named or equivalent effects, best first.
        status: label → ``named``, ``equivalent``, ``not_excited`` or ``rejected``.
        trial: where none is named although a gap remains, labels of effects that pass with the confidence of a trial,
            best first: worth going on with, to see whether what follows puts them beyond doubt.
        absorbed: labels of effects whose place the model's own free parameters can take on these data.
        reason: one sentence.
    """

    kind: str
    effects: tuple[str, ...]
    status: Mapping[str, str]
    trial: tuple[str, ...]
    absorbed: tuple[str, ...]
    reason: str


def decide(
    base: FittedModel, ranking: Sequence[Candidate], settings: EvidenceSettings, scored: str = "held-out logs"
) -> Verdict:
    """Judge a ranking, most evidence first.

    Among supported candidates that the best one does not beat beyond its interval, those with the fewest parameters
    stand: a richer effect that explains nothing more is not a rival. Where that is the best one itself, those stand as
    well that none of these beats. Of data too few for an interval that is not known, and a richer effect stays that
    seems to explain much more.

    Args:
        base: the model without them.
        ranking: the candidates.
        settings: when a gain counts.
        scored: the logs that the scores are from, in words.
    """
    # Far from the floor much helps a bit.
    helpful = [c for c in ranking if c.final and c.resolved and largest_gap(c.gain) >= settings.least_explained]
    group = _inseparable([c for c in helpful if _passes(supported, c, settings)], settings)
    absorbed = tuple(c.effect.label for c in ranking if c not in group and _absorbed(c, settings))
    status = {c.effect.label: _status(c, group, absorbed, settings) for c in ranking}
    labels = tuple(c.effect.label for c in group)
    kind = _kind(base, group, status, settings)
    doubtful = [c for c in helpful if kind == "unexplained" and _passes(worth_a_trial, c, settings)]
    trial = _inseparable(doubtful, settings)
    reason = _reason(kind, base, group, status, settings, scored) + _prospect(trial, settings)
    return Verdict(kind, labels, status, tuple(c.effect.label for c in trial), absorbed, reason)


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
        left = ", ".join(f"{c.effect.label} (mean χ² {c.explained.held_out.chi2:.4g})" for c in group)
        return f"The {scored} cannot separate {left}: what one explains better than another is not beyond doubt."
    floor = noise_floor(base.held_out.freedom, settings)
    place = f"above the noise floor ({floor:.3g})" if kind == "unexplained" else "at the noise floor"
    mean = f"mean χ² {base.held_out.chi2:.3f} on the {scored}"
    told = f"The model is {place}, {mean}, and no effect of the catalogue lowers it credibly."
    silent = ", ".join(label for label, each in status.items() if each == "not_excited")
    return f"{told} Over the whole width of their bounds these would not show: {silent}." if silent else told


def _prospect(trial: Sequence[Candidate], settings: EvidenceSettings) -> str:
    """What is worth a trial, in words."""
    if not trial:
        return ""
    gain, confidence = trial[0].gain, 100 * settings.trial_confidence
    return (
        f" Worth a trial, which dr-lab close makes as far as most allows, is {trial[0].effect.label}: it closes "
        f"{100 * gain.gap:.3g} % of a typical window's gap with evidence Δχ² {gain.total:.4g}, in doubt because it "
        f"differs from window to window ({confidence:.3g} % interval from {gain.trial_low:.4g}, "
        f"{100 * settings.confidence:.3g} % interval from {gain.total_low:.4g})."
    )


def _worth(base: FittedModel, candidate: Candidate, settings: EvidenceSettings) -> str:
    """What decides for a candidate, and beside it the mean χ², on which a single wild window weighs more."""
    gain, means = candidate.gain, (base.held_out.chi2, candidate.explained.held_out.chi2)
    needed = settings.threshold + settings.penalty * len(candidate.effect.parameters)
    low = f"{100 * settings.confidence:.3g} % interval from {gain.total_low:.4g}"
    interval = f"{'too few data for an interval' if isnan(gain.total_low) else low}, {needed:g} needed"
    return (
        f"closes {100 * gain.gap:.3g} % of a typical window's gap with evidence Δχ² {gain.total:.4g} ({interval}), "
        f"mean χ² {means[0]:.3f} before and {means[1]:.3f} after,"
    )


def _inseparable(backed: Sequence[Candidate], settings: EvidenceSettings) -> list[Candidate]:
    """The best candidate and those it does not beat, without needless parameters, what stands nearest to a joint first.

    Where the best one turns out to be needlessly rich, those join that what takes its place does not beat either; they
    displace nothing. What seems to explain much more than another one goes before it.
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
    return sorted(kept, key=lambda c: (sum(_seems_ahead(other, c, settings) for other in kept), *_nearness(c)))


def _beats(candidate: Candidate, other: Candidate, settings: EvidenceSettings) -> bool:
    gain = paired_gain(other.explained.held_out, candidate.explained.held_out, settings)
    return supported(gain, 0, settings)


def _needed(group: list[Candidate], settings: EvidenceSettings) -> list[Candidate]:
    """Candidates than which none is more likely, and none poorer seems as good."""
    group = _likeliest(group, settings)
    return [c for c in group if all(_seems_ahead(c, other, settings) for other in group if _richer(c, other))]


def _richer(candidate: Candidate, other: Candidate) -> bool:
    return len(candidate.effect.parameters) > len(other.effect.parameters)


def _seems_ahead(candidate: Candidate, other: Candidate, settings: EvidenceSettings) -> bool:
    """Whether a candidate explains a fair part of what another one leaves, on too few data to be certain of it."""
    gain = paired_gain(other.explained.held_out, candidate.explained.held_out, settings)
    extra = max(len(candidate.effect.parameters) - len(other.effect.parameters), 0)
    return isnan(gain.total_low) and sizeable(gain, extra, settings) and gain.gap >= settings.least_explained


def _likeliest(group: list[Candidate], settings: EvidenceSettings) -> list[Candidate]:
    """Of effects of which one leaves noise alone, those than which no other one is more likely.

    At the noise floor Δχ² is the likelihood ratio, to which the logs that were fitted contribute as well; it needs no
    interval, which few blocks of data make wide. Above the floor the models are wrong in ways that differ from log to
    log, and the intervals decide.
    """
    if not any(at_floor(c.explained.held_out, settings) for c in group):
        return group
    likeliest = [c for c in group if not any(_less_likely(c, other, settings) for other in group)]
    # Compared in different windows, as where one diverges, each can lose to another; then those stay that win at all.
    return likeliest or [c for c in group if any(_less_likely(other, c, settings) for other in group)]


def _less_likely(candidate: Candidate, other: Candidate, settings: EvidenceSettings) -> bool:
    """Whether all logs together make a candidate less likely than another one.

    To displace a poorer effect a richer one must be more likely on fitted and on held-out logs alike: what holds the
    truth gains on both, but a fit that ended early, or a start that was not found, shows on one of them. All
    others displace by the sum of both.
    """
    excess = _excess(candidate, other)
    needed = settings.threshold + settings.penalty * (len(other.effect.parameters) - len(candidate.effect.parameters))
    return (min(excess) if _richer(other, candidate) else sum(excess)) > needed


def _excess(candidate: Candidate, other: Candidate) -> tuple[float, ...]:
    """How much larger χ² a candidate leaves than another in windows that both simulate: of held-out, of fitted logs.

    It counts in units of the noise that the other leaves, per independent residual.

    Where no logs are held out the scored ones are those that were fitted, and count once.
    """
    ours, theirs = candidate.explained.held_out, other.explained.held_out
    both = (ours.window_count > 0) & (theirs.window_count > 0)
    unit = max(theirs.chi2, 1.0) * theirs.colour
    held_out = float((ours.window_sum - theirs.window_sum)[both].sum()) / unit
    fitted = other.explained.fit.below(candidate.explained.fit) / unit
    return (held_out, fitted) if candidate.explained.apart else (held_out,)


def _nearness(candidate: Candidate) -> tuple[int, float]:
    """Order among inseparable effects: the catalogue's families, from the joint outwards, then held-out χ²."""
    return FAMILIES.index(candidate.effect.effect.family), candidate.explained.held_out.chi2


def _absorbed(candidate: Candidate, settings: EvidenceSettings) -> bool:
    known = candidate.identifiability
    excited = known.alone >= settings.threshold
    return excited and (known.share < settings.absorbed or known.beside < settings.threshold)


def _status(
    candidate: Candidate, group: Sequence[Candidate], absorbed: Sequence[str], settings: EvidenceSettings
) -> str:
    if candidate in group:
        return "named" if len(group) == 1 else "equivalent"
    if candidate.identifiability.alone < settings.threshold:
        return "not_excited"
    gains = candidate.gain.low > 0  # of too few data nobody knows
    return "equivalent" if candidate.effect.label in absorbed and not gains else "rejected"
