"""The ladder of models: add the effect the data name, refit all, repeat until nothing more is supported.

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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import mujoco

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fitted_to_the_end
from dr_lab.diagnosis.evidence.confirmation import Confirmation
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.support import cleared
from dr_lab.diagnosis.search.as_special_case import holds
from dr_lab.diagnosis.search.climb_watch import ClimbWatch
from dr_lab.diagnosis.search.deletions import Deletions, labels
from dr_lab.diagnosis.search.in_place import weighed_anew
from dr_lab.diagnosis.search.law_check import LawCheck, check_laws
from dr_lab.diagnosis.search.pruning import Pruned, finished, lean
from dr_lab.diagnosis.search.put_back import PutBack
from dr_lab.diagnosis.search.rank import Ranking, beside, rank
from dr_lab.diagnosis.search.restack import reconsider
from dr_lab.diagnosis.search.rung import Rung
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.effects.catalogue import SpecialCases, candidates
from dr_lab.effects.effect import Effect, PlacedEffect, Scales
from dr_lab.physics.model import Model


@dataclass(frozen=True)
class Ladder:
    """A climbed ladder.

    Attributes:
        rungs: the rankings, in the order in which they were made.
        base: the calibrated model.
        steps: the added effects, in order.
        refused: why effects of the catalogue were not tried at a site, by ``effect@site``.
        dropped: labels of effects that were added, but without which the logs are explained as well in the end.
        put_back: effects that were added, but whose place one of their special cases has taken.
        laws: what free laws explain beside the added effects; empty where none was checked.
        confirmation: what those windows say that took no part in choosing the effects; None without such windows.
    """

    rungs: tuple[Rung, ...]
    base: FittedModel
    steps: tuple[AddedEffect, ...]
    refused: Mapping[str, str] = field(default_factory=dict)
    dropped: tuple[str, ...] = ()
    put_back: tuple[PutBack, ...] = ()
    laws: tuple[LawCheck, ...] = ()
    confirmation: Confirmation | None = None

    @property
    def absorbed(self) -> tuple[str, ...]:
        """Labels of effects whose place the free parameters can take, by the last rung whose model still stands."""
        return [r for r in self.rungs if any(r.base is model for model in self.models)][-1].verdict.absorbed

    @property
    def refuted(self) -> set[str]:
        """Labels of effects that were added and do not stand: they are not tried again."""
        return {*self.dropped, *(back.richer for back in self.put_back)}

    @property
    def models(self) -> tuple[FittedModel, ...]:
        """The ladder's models, the calibrated one first."""
        return (self.base, *(step.fitted_model for step in self.steps))

    def topped(self, last: FittedModel) -> "Ladder":
        """The ladder with a better fit of its last model; itself, whose deletions are known, where there is none."""
        if last is self.models[-1]:
            return self
        if not self.steps:
            return replace(self, base=last)
        return replace(self, steps=(*self.steps[:-1], replace(self.steps[-1], fitted_model=last)))

    def ended(self, bench: Bench) -> "Ladder":
        """The ladder with its last model, which is the answer, fitted to the end; in the rung that judged it, too."""
        last, end = self.models[-1], fitted_to_the_end(bench, self.models[-1])
        rungs = tuple(replace(rung, base=end) if rung.base is last else rung for rung in self.rungs)
        return replace(self.topped(end), rungs=rungs)

    def gained(self, settings: EvidenceSettings) -> Gain:
        """What all added effects gain together over the calibrated model."""
        return paired_gain(self.base.held_out, self.models[-1].held_out, settings)

    def closed(self, settings: EvidenceSettings) -> float:
        """Share of the calibrated model's gap that all effects close; 1 where they bring a channel to its floor.

        Within a short window fitted starts take up what a model lacks, such as a force that beats or a mass that
        sloshes. So the share is computed twice, with fitted starts and with starts that only earlier samples tell
        (where these are known), and the smaller one counts.
        """
        gain = self.gained(settings)
        if cleared(self.base.held_out, self.models[-1].held_out, gain, settings):
            return 1.0
        return gain.gap if self.confirmation is None else min(gain.gap, self.confirmation.predicted.gain.gap)

    def verdict(self, settings: EvidenceSettings) -> str:
        """What was found, by the first of these rules that holds.

        1. Without an added effect it is the first rung's verdict. If all that was added was dropped again, it is
           ``none`` at the noise floor and ``unexplained`` above.
        2. It is ``unexplained`` if the effects leave much of the gap, and more than noise: they are what the catalogue
           has nearest to the cause, rather than the cause.
        3. It is ``unexplained`` if an effect has another law than the machine, or if windows that took no part in
           choosing the effects contradict them.
        4. It is ``equivalent`` if an effect has rivals, otherwise ``named``.
        """
        noise = at_floor(self.models[-1].held_out, settings)
        if not self.steps:
            first = self.rungs[0].verdict
            return ("none" if noise else "unexplained") if first.effects and self.dropped else first.kind
        if not noise and self.closed(settings) < settings.least_named:
            return "unexplained"
        if any(law.refuted for law in self.laws) or (self.confirmation and self.confirmation.contradicts):
            return "unexplained"
        return "equivalent" if any(step.rivals for step in self.steps) else "named"

    def confirmed_by(self, found: Confirmation | None, settings: EvidenceSettings) -> "Ladder":
        """The ladder with what other windows say; without its effects where these contradict what was only noise."""
        if found is None or not found.contradicts or not at_floor(self.base.held_out, settings):
            return replace(self, confirmation=found)
        dropped = (*self.dropped, *(step.effect.label for step in self.steps))
        return replace(self, steps=(), dropped=dropped, confirmation=found)

    def without_last(self) -> "Ladder":
        """The ladder without its last effect, which is dropped."""
        return replace(self, steps=self.steps[:-1], dropped=(*self.dropped, self.steps[-1].effect.label))

    def with_laws(self, bench: Bench, scales: Scales, compiled: mujoco.MjModel) -> "Ladder":
        """The ladder with the laws of its effects checked; scales and nominal model as for `climb`."""
        return replace(self, laws=check_laws(bench, self.steps, scales, compiled))

    def with_first_step(self) -> "Ladder":
        """The ladder with the effect that its first rung names, where it names one."""
        return replace(self, steps=(self.rungs[0].step(),) if self.rungs[0].verdict.effects else ())

    def pruned(self, bench: Bench, cases: SpecialCases) -> "Ladder":
        """The ladder with no more effects, and none richer, than the logs ask for; see `pruning.finished`."""
        found = finished(Deletions(bench), self.base, self.steps, cases)
        return replace(self, steps=found.steps, dropped=found.dropped, put_back=found.put_back)


def climb(
    bench: Bench,
    base: FittedModel,
    effects: Mapping[str, Effect],
    scales: Scales,
    compiled: mujoco.MjModel,
    *,
    most: int,
    watch: ClimbWatch,
) -> Ladder:
    """Climb from a fitted base until a rung adds nothing, or needs more than `most` effects; by this module's rules.

    Args:
        bench: data and settings.
        base: the calibrated model.
        effects: the catalogue.
        scales: size of the effects' bounds.
        compiled: the compiled nominal model.
        most: most effects that are added; one that sits at several sites counts once.
        watch: is told what each ranking tries, and what was found where the climb goes on after it.
    """
    ladder, cases, deletions = Ladder((), base, ()), SpecialCases(effects, scales, compiled), Deletions(bench)
    while True:
        found = candidates(ladder.models[-1].model, effects, scales, compiled, bench.fit.channels)
        placed = _to_try(ladder, found.placed, bench.evidence)
        ranking = _as_before(ladder, placed, bench.evidence)
        ranking = ranking or _elsewhere(bench, ladder, placed, watch)
        ranking = ranking or rank(bench, ladder.models[-1], placed, watch.ranking(len(placed)))
        ladder = replace(ladder.topped(ranking.base), refused={**found.refused, **ladder.refused})
        ladder, over = _with_rung(deletions, ladder, ranking, cases, most)
        if over:
            placed = [effect for effect in found.placed if effect.label not in ladder.refuted]
            ladder = replace(ladder, steps=weighed_anew(deletions, base, ladder.steps, placed, ladder.rungs, watch))
        if over and any(judged.base is ladder.models[-1] for judged in ladder.rungs):
            return ladder
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
    ranking = rank(bench, last, same, watch.ranking(len(same)))
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
    return replace(ladder, rungs=rungs, steps=steps, dropped=dropped, put_back=put_back), over
