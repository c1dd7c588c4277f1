"""A climb: add the effect that the data name, refit all, repeat until nothing more is supported.

1. A rung adds the first of the effects that it names. The others are its rivals, which each later rung reconsiders:
   a rival that explains more beside what was added since takes its place, one that explains less is dropped. So
   it is, too, where effects beside it are dropped.
2. A rung that names none adds the first effect that is worth a trial. It is judged when the climb is over, before
   the others. Until then no effect is dropped, lest what is in doubt take the place of what is not.
3. An effect is dropped for good if the last model explains the logs as well without it. If that is in doubt, it
   stays until the climb is over, because what is still missing scatters what it gains.
4. An effect that holds a special case is put back to that for good, unless its further parameters are beyond doubt.
   This is decided once another effect stands beside it, and when the climb is over.
5. If this leaves a model that was not judged before, the climb goes on from there.
6. Beside a model that leaves noise, richer kinds of what it holds are not tried: they were weighed against it.
   Where that was beside other effects than now, they are weighed anew when the climb is over (`weighed_anew`).
7. After an effect is added the same one at other sites is asked first, for a machine's joints are built alike, and
   the whole catalogue where none of these is added. What is added so is weighed against others in the end, too.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.search.as_special_case import holds
from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.diagnosis.search.deletions import Deletions, labels
from dr_lab.diagnosis.search.in_place import weighed_anew
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.pruning import Pruned, finished, lean
from dr_lab.diagnosis.search.rank import Ranking, beside, rank
from dr_lab.diagnosis.search.restack import reconsider
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.catalogue import SpecialCases, candidates
from dr_lab.effects.effect import Effect, PlacedEffect, Scales
from dr_lab.physics.model import Model


@dataclass(frozen=True)
class Climb:
    """How far a climb has come, all that it takes to go on.

    Attributes:
        ladder: as it stands.
        deletions: what is known of ladders that lack one effect, and the bench on which models are compared.
    """

    ladder: Ladder
    deletions: Deletions

    @classmethod
    def begun(cls, bench: Bench, base: FittedModel) -> "Climb":
        """A climb that stands on the calibrated model, `base`; `bench` has the data and settings."""
        return cls(Ladder((), base, ()), Deletions(bench))


def kept_nowhere(climb: Climb) -> None:
    """Keep it not: a climb from which nobody will go on."""


def climb(
    begun: Climb,
    effects: Mapping[str, Effect],
    scales: Scales,
    compiled: mujoco.MjModel,
    *,
    most: int,
    watch: ClimbWatch,
    keep: Callable[[Climb], None] = kept_nowhere,
) -> Ladder:
    """Climb until a rung adds nothing, or needs more than `most` effects; by this module's rules.

    Args:
        begun: where the climb stands; its `deletions` learn more.
        effects: the catalogue.
        scales: size of the effects' bounds.
        compiled: the compiled nominal model.
        most: most effects that are added; one that sits at several sites counts once.
        watch: is told what each ranking tries, and what was found where the climb goes on after it.
        keep: is given how far the climb has come where it goes on, from where another call would end with the same.
    """
    ladder, deletions, cases = begun.ladder, begun.deletions, SpecialCases(effects, scales, compiled)
    bench = deletions.bench
    while True:
        found = candidates(ladder.models[-1].model, effects, scales, compiled, bench.fit.channels)
        placed = _to_try(ladder, found.placed, bench.evidence)
        ranking = _as_before(ladder, placed, bench.evidence)
        ranking = ranking or _elsewhere(bench, ladder, placed, watch)
        ranking = ranking or rank(bench, ladder.models[-1], placed, watch.ranking(labels(placed)))
        ladder = replace(ladder.topped(ranking.base), refused={**found.refused, **ladder.refused})
        ladder, over = _with_rung(deletions, ladder, ranking, cases, most)
        if over:
            placed = [effect for effect in found.placed if effect.label not in ladder.refuted]
            steps = weighed_anew(deletions, ladder.base, ladder.steps, placed, ladder.rungs, watch)
            ladder = replace(ladder, steps=steps)
        if over and any(judged.base is ladder.models[-1] for judged in ladder.rungs):
            return ladder
        keep(Climb(ladder, deletions))
        _tell(watch, ladder)


def _tell(watch: ClimbWatch, ladder: Ladder) -> None:
    first, last = ladder.base.held_out, ladder.models[-1].held_out
    watch.found([step.effect.label for step in ladder.steps], first.chi2, last.chi2)


def _elsewhere(bench: Bench, ladder: Ladder, placed: Sequence[PlacedEffect], watch: ClimbWatch) -> Ranking | None:
    """The ranking of the effect that was added last at the other sites, if it adds one; None where noise is left.

    Where the effect stands at several sites, one more is added on trial, too: what the others still miss scatters what
    it gains.
    """
    last, rungs = ladder.models[-1], ladder.rungs
    if not ladder.steps or at_floor(last.held_out, bench.evidence) or not _first(rungs[-1]):
        return None
    name = ladder.steps[-1].effect.effect.name
    same = [effect for effect in placed if effect.effect.name == name]
    several = sum(step.proven and step.effect.effect.name == name for step in ladder.steps) > 1
    if not 0 < len(same) < len(placed) or not (ladder.steps[-1].proven or several):
        return None
    ranking = rank(bench, last, same, watch.ranking(labels(same)))
    verdict = Rung.judged(bench, ranking.base, ranking.candidates).verdict
    return ranking if verdict.effects or (several and verdict.trial) else None


def _as_before(ladder: Ladder, placed: Sequence[PlacedEffect], settings: EvidenceSettings) -> Ranking | None:
    """The ranking of these effects beside an earlier model at the noise floor with the effects of the last one, if any.

    Beside such a model no effect stands out, and a slightly better fit of it changes its candidates' gains alone.
    """
    last, wanted = ladder.models[-1], {effect.label for effect in placed}
    for rung in reversed(ladder.rungs):
        kept = [candidate for candidate in rung.ranking if candidate.effect.label in wanted]
        alike = labels(rung.base.model.effects) == labels(last.model.effects) and len(kept) == len(wanted)
        if alike and all(at_floor(model.held_out, settings) for model in (rung.base, last)):
            return Ranking(last, beside(last, kept, settings))
    return None


def _to_try(ladder: Ladder, placed: Sequence[PlacedEffect], settings: EvidenceSettings) -> list[PlacedEffect]:
    """Those of the placed effects that a rung tries beside the ladder's last model."""
    last, new = ladder.models[-1], [effect for effect in placed if effect.label not in ladder.refuted]
    return [effect for effect in new if not _richer(effect, last.model)] if at_floor(last.held_out, settings) else new


def _richer(effect: PlacedEffect, model: Model) -> bool:
    """Whether a model has a special case of the effect, which was weighed against it when it was added."""
    return any(isinstance(each, PlacedEffect) and holds(effect, each) for each in model.effects)


def _adds(rung: Rung, steps: Sequence[AddedEffect], most: int) -> bool:
    """Whether a rung finds something to add, and there is room for it."""
    names = {step.effect.effect.name for step in steps} | {label.partition("@")[0] for label in _first(rung)}
    return bool(_first(rung)) and len(names) <= most


def _first(rung: Rung) -> tuple[str, ...]:
    """The label of what a rung adds: what it names first, or else finds worth a trial; nothing where there is none."""
    return (*rung.verdict.effects, *rung.verdict.trial)[:1]


def _with_rung(
    deletions: Deletions, ladder: Ladder, ranking: Ranking, cases: SpecialCases, most: int
) -> tuple[Ladder, bool]:
    """The ladder with what one ranking adds and without what that makes needless; and whether the climb is over."""
    bench = deletions.bench
    deletions.ranked(ranking.candidates)
    rung = Rung.judged(bench, ranking.base, ranking.candidates)
    over = not _adds(rung, ladder.steps, most)
    steps = ladder.steps
    if not over:
        step, end = rung.step(), rung.step().ended(bench)
        if ranking.back_from is step.fitted_model.fit:  # both end in one valley
            deletions.tried(end.fitted_model.fit)
        steps = reconsider(bench, ladder.base, (*steps, end), range(len(steps)))
    if over:
        pruned = finished(deletions, ladder.base, steps, cases)
    else:
        pruned = lean(deletions, ladder.base, steps, cases) if all(s.proven for s in steps) else Pruned(steps)
    steps = pruned.steps
    if pruned.dropped or pruned.put_back:
        steps = reconsider(bench, ladder.base, steps, range(len(steps)))
    dropped, put_back = (*ladder.dropped, *pruned.dropped), (*ladder.put_back, *pruned.put_back)
    rungs = (*ladder.rungs, rung)
    return replace(ladder, rungs=rungs, steps=steps, dropped=dropped, put_back=put_back, doubt=pruned.doubt), over
