"""No more effects on a ladder, and none richer, than the logs ask for beyond doubt."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, beyond_doubt
from dr_lab.diagnosis.evidence.compatible import chance_within
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.support import sizeable, supported
from dr_lab.diagnosis.search.as_special_case import reaching
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.hidden_by_step import hidden_by_step
from dr_lab.diagnosis.search.put_back import PutBack, Swap, asked_for, closes_little
from dr_lab.diagnosis.search.restack import swap
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.search.uncertainty import known
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.catalogue import SpecialCases

Rule = Callable[[Gain, int, EvidenceSettings], bool]


@dataclass(frozen=True)
class Doubt:
    """An effect that was dropped as the last one, so that nothing stands.

    Attributes:
        base: the calibrated model.
        step: the model with that effect alone.
    """

    base: FittedModel
    step: AddedEffect


@dataclass(frozen=True)
class Pruned:
    """What is left of a ladder's steps.

    Attributes:
        steps: those that stay, refitted and proven.
        dropped: labels of the effects that were dropped.
        put_back: the effects that were put back to a special case.
        doubt: the last effect that was dropped, where none stays; None where some do, or none was there.
    """

    steps: tuple[AddedEffect, ...]
    dropped: tuple[str, ...] = ()
    put_back: tuple[PutBack, ...] = ()
    doubt: Doubt | None = None


def lean(deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], cases: SpecialCases) -> Pruned:
    """Put back what is needlessly rich, then drop what is superfluous.

    The order has two reasons:

    1. A richer effect can make up for another one that is missing. That one then seems superfluous beside it.
    2. An effect that softens the faults of a richer one may be superfluous beside the poorer one.

    A lone effect is put back only if it leaves noise: what is still missing beside it may blur what it is. For the same
    reason an effect of some size whose gain is in doubt stays until the climb is over, unless only noise is left.
    """
    noise = at_floor(steps[-1].fitted_model.held_out, deletions.bench.evidence)
    simpler, put_back = _put_back(deletions, base, steps, cases) if noise or len(steps) > 1 else (steps, ())
    return replace(prune(deletions, base, simpler, supported if noise else sizeable), put_back=put_back)


def finished(deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], cases: SpecialCases) -> Pruned:
    """What is left of the steps when the climb is over.

    1. Effects that the evidence does not support are dropped, those on trial first.
    2. Needlessly rich effects are put back, also where a rival in the place of another effect makes them so, and what
       is then superfluous is dropped.
    3. Effects of one parameter whose value is compatible with absent are dropped. This waits until here: as long as
       other effects are missing, what they would explain widens the scatter between logs.
    """
    found = prune(deletions, base, steps, supported)
    kept, put_back = _put_back(deletions, base, found.steps, cases)
    kept, more = plainer(deletions, base, kept, cases)
    put_back = (*put_back, *more)
    further = prune(deletions, base, kept, supported) if put_back else Pruned(kept)
    kept, absent = drop_absent(deletions, base, further.steps)
    kept = tuple(replace(step, proven=True) for step in kept)
    return Pruned(kept, (*found.dropped, *further.dropped, *absent), put_back, found.doubt or further.doubt)


def prune(deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], stays: Rule) -> Pruned:
    """Drop effects without which the logs are explained as well. Those on trial are judged first, in order of addition.

    Args:
        deletions: ladders that lack one effect, and the bench on which they are compared.
        base: the calibrated model.
        steps: what was added.
        stays: the rule by which an effect with so many parameters stays for its gain: `sizeable` or `supported`.

    """
    for place in sorted(range(len(steps)), key=lambda k: steps[k].proven):
        fewer, base, needed = _without(deletions, base, steps, place, stays)
        if not needed:
            found = prune(deletions, base, fewer, stays)
            dropped = (steps[place].effect.label, *found.dropped)
            return replace(found, dropped=dropped, doubt=found.doubt if fewer else Doubt(base, steps[0]))
    return Pruned(steps)


def _without(
    deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], place: int, stays: Rule
) -> tuple[tuple[AddedEffect, ...], FittedModel, bool]:
    """The steps without one of them, their base, and whether that one stays.

    A fit that is given up tells that it stays; else the fit's end decides: short of it, the gain scatters from window
    to window by where the fit was.
    """
    whole, count = steps[-1].fitted_model, len(steps[place].effect.parameters)
    goal = beyond_doubt(deletions.bench, whole)
    fewer, base = deletions.without(base, steps, place, goal)
    if _gains(deletions, base, fewer, whole, count, stays):
        return fewer, base, True
    if not _ended_early(_last(base, fewer), goal):
        return fewer, base, False
    fewer, base = deletions.without(base, steps, place)
    return fewer, base, _gains(deletions, base, fewer, whole, count, stays)


def _gains(
    deletions: Deletions,
    base: FittedModel,
    fewer: tuple[AddedEffect, ...],
    whole: FittedModel,
    count: int,
    asked: Rule,
) -> bool:
    """Whether a model gains enough over fewer steps for so many parameters more."""
    evidence = deletions.bench.evidence
    return asked(paired_gain(_last(base, fewer).held_out, whole.held_out, evidence), count, evidence)


def _last(base: FittedModel, steps: tuple[AddedEffect, ...]) -> FittedModel:
    return steps[-1].fitted_model if steps else base


def drop_absent(
    deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...]
) -> tuple[tuple[AddedEffect, ...], tuple[str, ...]]:
    """Drop effects of one parameter whose value is compatible with absent, the most doubtful one first.

    The parameter's uncertainty is the stated one (`uncertainty.known`), which holds the scatter between logs and what
    the time step moves: an effect that makes up for the step's error is no physics. Only its gain judges an effect of
    several parameters: near absent its shape means nothing, and a Wald test's answer depends on how the parameters are
    written down. Of an elasticity, for example, often only compliance times inertia is known. What others would have to
    do in its place counts as far as their bounds let them: a damping goes no lower than 0.

    Source: Gregory and Veall, Econometrica 53 (1985) 1465.

    Returns:
        The steps that stay, refitted, and the labels of the effects that were dropped.
    """
    if not steps:
        return (), ()
    bench = deletions.bench
    found = known(bench, steps[-1].fitted_model).estimate
    doubts = [chance_within(found, step.effect.absent) if len(step.effect.parameters) == 1 else 0.0 for step in steps]
    place = int(np.argmax(doubts))
    if doubts[place] < 1 - bench.evidence.confidence:
        return steps, ()
    fewer, base = deletions.without(base, steps, place)
    kept, dropped = drop_absent(deletions, base, fewer)
    return kept, (steps[place].effect.label, *dropped)


def simplify(
    deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], cases: SpecialCases
) -> tuple[tuple[AddedEffect, ...], PutBack] | None:
    """Put one effect back to a special case of it: the earliest effect that is needlessly rich.

    The richer effect stands in two cases:

    1. The logs ask for it (`put_back.asked_for`), it closes a good part even of a gap that hardly shows
       (`put_back.closes_little`), and the time step of the poorer one does little of what it changes
       (`hidden_by_step`).
    2. The poorer one in its place would not be beyond doubt itself. Then the doubt is which of the two is there, not
       whether one is.

    Returns:
        The steps with the poorer effect in its place, refitted, and what was put back; None where all stand.
    """
    bench, whole = deletions.bench, _last(base, steps)
    for place, step in enumerate(steps):
        for poorer in cases.of(step.effect, whole.model):
            swap = Swap(step.effect, reaching(poorer, step.effect))
            simpler, back = _weighed(swap, deletions, base, whole)
            if back is None or not _stands(deletions, base, steps, place, simpler, len(poorer.parameters)):
                continue
            between = (replace(s, fitted_model=swap.made(bench, base, s.fitted_model)) for s in steps[place:-1])
            above = [*between, replace(steps[-1], fitted_model=simpler)]
            above[0] = replace(above[0], rivals=swap.rivals(step))
            return (*steps[:place], *above), back
    return None


def _weighed(
    swap: Swap, deletions: Deletions, base: FittedModel, whole: FittedModel
) -> tuple[FittedModel, PutBack | None]:
    """The model with the poorer effect, and what is put back; None where the logs ask for the richer effect."""
    bench, extra = deletions.bench, len(swap.richer.parameters) - len(swap.poorer.parameters)
    back = swap.put_back(bench, whole)
    if back.at_limit:
        return _at_limit(swap, deletions, base, whole), back
    goal = beyond_doubt(bench, whole)
    simpler = swap.made(bench, base, whole, goal)
    found = _without_need(simpler, whole, back, extra, bench)
    if found is not None and _ended_early(simpler, goal):
        simpler = swap.made(bench, base, whole)
        found = _without_need(simpler, whole, back, extra, bench)
    return simpler, found


def _at_limit(swap: Swap, deletions: Deletions, base: FittedModel, whole: FittedModel) -> FittedModel:
    """The model with the poorer effect, which the richer one has become: as ranked, if that leaves noise."""
    known = deletions.as_ranked(swap.effects(whole.model))
    if known is not None and at_floor(known.held_out, deletions.bench.evidence):
        return known
    return swap.made(deletions.bench, base, whole)


def _without_need(simpler: FittedModel, whole: FittedModel, back: PutBack, extra: int, bench: Bench) -> PutBack | None:
    """What is put back, with the reason; None where the logs ask for the richer model."""
    if not asked_for(simpler, whole, back, extra, bench.evidence):
        return back
    little = closes_little(simpler, whole, bench.evidence)
    hidden = not little and hidden_by_step(bench, simpler, whole)
    return replace(back, little=little, hidden=hidden) if little or hidden else None


def _stands(
    deletions: Deletions,
    base: FittedModel,
    steps: tuple[AddedEffect, ...],
    place: int,
    swapped: FittedModel,
    count: int,
) -> bool:
    """Whether a model with another effect at a place, of so many parameters, is supported over one with none there."""
    fewer, base = deletions.without(base, steps, place)
    return _gains(deletions, base, fewer, swapped, count, supported)


def _put_back(
    deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], cases: SpecialCases
) -> tuple[tuple[AddedEffect, ...], tuple[PutBack, ...]]:
    """The steps with every needlessly rich effect put back, and what was put back."""
    found = simplify(deletions, base, steps, cases)
    if found is None:
        return steps, ()
    simpler, more = _put_back(deletions, base, found[0], cases)
    return simpler, (found[1], *more)


def plainer(
    deletions: Deletions, base: FittedModel, steps: tuple[AddedEffect, ...], cases: SpecialCases
) -> tuple[tuple[AddedEffect, ...], tuple[PutBack, ...]]:
    """The steps with a rival in the place of an effect beside which a richer one is put back, and what was put back.

    Two effects may share what a single other one does: a tilt of the base pulls at every joint, where an offset pulls
    at one, and friction that differs by direction makes up for the next. The logs must not ask for the two.
    """
    bench, whole = deletions.bench, _last(base, steps)
    rich = {place for place, step in enumerate(steps) if cases.of(step.effect, whole.model)}
    for place, rival in [(k, rival) for k, step in enumerate(steps) if rich - {k} for rival in step.rivals]:
        swapped = swap(bench, base, steps, place, rival)
        lost = paired_gain(swapped[-1].fitted_model.held_out, whole.held_out, bench.evidence)
        found, back = (steps, ()) if supported(lost, 0, bench.evidence) else _put_back(deletions, base, swapped, cases)
        if back:
            return found, back
    return steps, ()


def _ended_early(fitted_model: FittedModel, goal: float) -> bool:
    """Whether a fit was given up because it would not reach its goal."""
    return bool(np.isfinite(goal)) and fitted_model.fit.cost > goal
