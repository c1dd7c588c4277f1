"""Effects that were added, ranked anew in their place beside all that stands when a climb is over."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.search.as_special_case import holds, reaching
from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.diagnosis.search.deletions import Deletions, labels
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import PlacedEffect

_AS_GOOD = 2  # effects; each costs a fit


def weighed_anew(
    deletions: Deletions,
    base: FittedModel,
    steps: tuple[AddedEffect, ...],
    placed: Sequence[PlacedEffect],
    rungs: Sequence[Rung],
    watch: ClimbWatch,
) -> tuple[AddedEffect, ...]:
    """The steps with another effect in the place of the first one that does not stand there.

    An effect is ranked anew in its place, beside all others that stand now, with its rivals and these:

    1. Where the steps leave noise, its richer kinds that were not ranked beside the same others. They may have been
       compared while another effect was missing, or another one stood in for it; what that left decided between them.
    2. Where they leave more than noise, what had explained as much with more parameters: what that bends to beside
       a missing effect, and what it explains beside all that stands, are two things.
    3. Where it was compared with the same effect at other sites alone, what it may be confused with.

    Args:
        deletions: ladders that lack one effect, and the bench on which effects are compared.
        base: the calibrated model.
        steps: what was added.
        placed: the effects that may be tried.
        rungs: what was ranked before.
        watch: is told what each ranking tries.
    """
    kept, bench = list(steps), deletions.bench
    noise = bool(steps) and at_floor(steps[-1].fitted_model.held_out, bench.evidence)
    for place, step in enumerate(steps):
        others = {other.effect.label for other in steps if other is not step}
        richer = [e for e in placed if noise and holds(e, step.effect) and not _known(e, others, rungs)]
        as_good = [] if noise else _as_good(step, placed, rungs)
        confused = _confused(step, placed) if step.alike else []
        asked = {e.label: reaching(e, step.effect) for e in (*richer, *as_good, *confused)}
        if not asked:
            continue
        fewer, ground = deletions.without(base, steps, place)
        rung = _ranked(bench, fewer[-1].fitted_model if fewer else ground, step, asked, watch)
        standing = {c.effect.label: c for c in rung.ranking if c.effect.label in rung.verdict.effects}
        if standing.pop(step.effect.label, None):
            kept[place] = replace(step, rivals=tuple(standing.values()), alike=False) if step.alike else step
        elif standing and rung.step().effect.label in asked:
            return (*fewer, rung.step().ended(bench))
    return tuple(kept)


def _ranked(
    bench: Bench, below: FittedModel, step: AddedEffect, asked: Mapping[str, PlacedEffect], watch: ClimbWatch
) -> Rung:
    """The effect of a step ranked with its rivals and others, by label, beside a model without it."""
    rivals = [rival.effect for rival in step.rivals if rival.effect.label not in asked]
    pool = [step.effect, *rivals, *asked.values()]
    ranking = rank(bench, below, pool, watch.ranking(labels(pool)))
    return Rung.judged(bench, ranking.base, ranking.candidates)


def _as_good(step: AddedEffect, placed: Sequence[PlacedEffect], rungs: Sequence[Rung]) -> list[PlacedEffect]:
    """The first of those that explained as much as the step's effect with more parameters, where that was named."""
    rung = next((each for each in rungs if step.effect.label in each.verdict.effects), None)
    found = {e.label: e for e in placed if not holds(e, step.effect)}
    order = [] if rung is None else [c.effect.label for c in rung.ranking]
    return [found[n] for n in order if rung and rung.verdict.status[n] == "not_needed" and n in found][:_AS_GOOD]


def _known(kind: PlacedEffect, others: set[str], rungs: Sequence[Rung]) -> bool:
    """Whether an effect was ranked beside these others."""
    return any(
        {effect.label for effect in rung.base.model.effects} == others
        and any(candidate.effect.label == kind.label for candidate in rung.ranking)
        for rung in rungs
    )


def _confused(step: AddedEffect, placed: Sequence[PlacedEffect]) -> list[PlacedEffect]:
    """What the step's effect may be confused with: at its site if it can sit there, otherwise wherever it can."""
    ours = step.effect.effect
    near = [e for e in placed if e.effect.name in ours.confused_with or ours.name in e.effect.confused_with]
    here = {e.effect.name for e in near if e.site == step.effect.site}
    return [e for e in near if e.site == step.effect.site or e.effect.name not in here]
