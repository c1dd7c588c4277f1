"""Richer kinds of what was added, weighed in its place beside all that stands when a climb is over."""

from collections.abc import Sequence

from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.search.as_special_case import holds, reaching
from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import PlacedEffect


def enriched(
    deletions: Deletions,
    base: FittedModel,
    steps: tuple[AddedEffect, ...],
    placed: Sequence[PlacedEffect],
    rungs: Sequence[Rung],
    watch: ClimbWatch,
) -> tuple[AddedEffect, ...]:
    """The steps with a richer kind in the place of the first effect whose place the logs give to one.

    An effect and its richer kinds may have been compared while another effect was missing, or another one stood in for
    it. What that left decided between them. So the effect, its rivals and those kinds are ranked anew beside all other
    effects that stand now.

    Args:
        deletions: ladders that lack one effect, and the bench on which effects are compared.
        base: the calibrated model.
        steps: what was added, which leaves noise.
        placed: the effects that may be tried.
        rungs: what was ranked before. A kind that was ranked beside the same other effects is not asked again.
        watch: is told what each ranking tries.
    """
    for place, step in enumerate(steps):
        others = {other.effect.label for k, other in enumerate(steps) if k != place}
        kinds = [reaching(e, step.effect) for e in placed if holds(e, step.effect) and not _known(e, others, rungs)]
        if not kinds:
            continue
        fewer, ground = deletions.without(base, steps, place)
        below = fewer[-1].fitted_model if fewer else ground
        richer = {kind.label for kind in kinds}
        pool = [step.effect, *(rival.effect for rival in step.rivals if rival.effect.label not in richer), *kinds]
        ranking = rank(deletions.bench, below, pool, watch.ranking(len(pool)))
        rung = Rung.judged(deletions.bench, ranking.base, ranking.candidates)
        if rung.verdict.effects and rung.step().effect.label in richer:
            return (*fewer, rung.step().ended(deletions.bench))
    return steps


def _known(kind: PlacedEffect, others: set[str], rungs: Sequence[Rung]) -> bool:
    """Whether an effect was ranked beside these others."""
    return any(
        {effect.label for effect in rung.base.model.effects} == others
        and any(candidate.effect.label == kind.label for candidate in rung.ranking)
        for rung in rungs
    )
