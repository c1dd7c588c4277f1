"""Effects that were added, ranked anew in their place beside all that stands when a climb is over."""

from collections.abc import Sequence
from dataclasses import replace

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.search.as_special_case import holds, reaching
from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import PlacedEffect


def weighed_anew(
    deletions: Deletions,
    base: FittedModel,
    steps: tuple[AddedEffect, ...],
    placed: Sequence[PlacedEffect],
    rungs: Sequence[Rung],
    watch: ClimbWatch,
) -> tuple[AddedEffect, ...]:
    """The steps with another effect in the place of the first one whose place the logs give to another.

    An effect is ranked anew in its place, beside all others that stand now, with its rivals and these:

    1. Where the steps leave noise, its richer kinds that were not ranked beside the same others. They may have been
       compared while another effect was missing, or another one stood in for it; what that left decided between them.
    2. Where it was compared with the same effect at other sites alone, what it may be confused with.

    Args:
        deletions: ladders that lack one effect, and the bench on which effects are compared.
        base: the calibrated model.
        steps: what was added.
        placed: the effects that may be tried.
        rungs: what was ranked before.
        watch: is told what each ranking tries.
    """
    kept, noise = list(steps), at_floor(steps[-1].fitted_model.held_out, deletions.bench.evidence) if steps else False
    for place, step in enumerate(steps):
        others = {other.effect.label for k, other in enumerate(steps) if k != place}
        richer = [e for e in placed if noise and holds(e, step.effect) and not _known(e, others, rungs)]
        asked = {e.label: reaching(e, step.effect) for e in (*richer, *(_confused(step, placed) if step.alike else ()))}
        if not asked:
            continue
        fewer, ground = deletions.without(base, steps, place)
        pool = [
            step.effect,
            *(rival.effect for rival in step.rivals if rival.effect.label not in asked),
            *asked.values(),
        ]
        below = fewer[-1].fitted_model if fewer else ground
        found = _ranked(deletions, below, pool, watch)
        if found is not None and found.effect.label in asked:
            return (*fewer, found.ended(deletions.bench))
        if found is not None and step.alike:
            kept[place] = replace(step, rivals=found.rivals, alike=False)
    return tuple(kept)


def _ranked(
    deletions: Deletions, below: FittedModel, pool: Sequence[PlacedEffect], watch: ClimbWatch
) -> AddedEffect | None:
    """What a ranking of some effects names; None where it names none."""
    ranking = rank(deletions.bench, below, pool, watch.ranking(len(pool)))
    rung = Rung.judged(deletions.bench, ranking.base, ranking.candidates)
    return rung.step() if rung.verdict.effects else None


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
