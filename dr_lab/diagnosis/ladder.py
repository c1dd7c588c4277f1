"""The ladder of models: add the effect the data name, refit all, repeat until nothing more is supported."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.bench import Bench, Explained, explain
from dr_lab.diagnosis.evidence import Gain, at_floor, paired_gain, supported
from dr_lab.diagnosis.rank import Candidate, rank
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.diagnosis.verdict import Verdict, decide
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import Effect, Scales

Watch = Callable[[int], Callable[[str], None]]


@dataclass(frozen=True)
class Rung:
    """One model that was judged, and what the catalogue could do for it.

    Attributes:
        base: the model, refitted and scored.
        ranking: the candidates beside it, best first.
        verdict: the judgement on them.
    """

    base: Explained
    ranking: tuple[Candidate, ...]
    verdict: Verdict


@dataclass(frozen=True)
class Step:
    """One effect that was added.

    Attributes:
        explained: the model with it.
        rivals: fitted alternatives that these data cannot separate from it, given all that was added since.
        proven: whether it was added with support, or kept when trials were over; else it is on trial, or a user added
            it.
    """

    explained: Explained
    rivals: tuple[Candidate, ...]
    proven: bool = True


@dataclass(frozen=True)
class Ladder:
    """A climbed ladder.

    Attributes:
        rungs: the rankings, in the order in which they were made.
        base: the calibrated model.
        steps: the added effects, in order.
        refused: why effects of the catalogue were not tried at a site, by ``effect@site``.
        dropped: labels of effects that were added and without which the logs are explained as well in the end.
    """

    rungs: tuple[Rung, ...]
    base: Explained
    steps: tuple[Step, ...]
    refused: Mapping[str, str] = field(default_factory=dict)
    dropped: tuple[str, ...] = ()

    @property
    def absorbed(self) -> tuple[str, ...]:
        """Labels of effects whose place the free parameters can take: those of the last rung that still stands."""
        return [r for r in self.rungs if any(r.base is model for model in self.models)][-1].verdict.absorbed

    @property
    def models(self) -> tuple[Explained, ...]:
        """The ladder's models, the calibrated one first."""
        return (self.base, *(step.explained for step in self.steps))

    def topped(self, last: Explained) -> "Ladder":
        """The ladder with a better fit of its last model."""
        if not self.steps:
            return replace(self, base=last)
        return replace(self, steps=(*self.steps[:-1], replace(self.steps[-1], explained=last)))

    def gained(self, settings: EvidenceSettings) -> Gain:
        """What all added effects gain together over the calibrated model."""
        return paired_gain(self.base.held_out, self.models[-1].held_out, settings)

    def closed(self, settings: EvidenceSettings) -> float:
        """Share of the calibrated model's gap that all added effects close together; `Gain.gap` of the last model."""
        return self.gained(settings).gap

    def verdict(self, settings: EvidenceSettings) -> str:
        """What was found: the first rung's verdict where nothing was added, else whether every effect stands alone.

        Effects that leave much of the gap, and more than noise, are what the catalogue has nearest to the cause rather
        than the cause: ``unexplained``. Where all that was added was dropped again, no effect is named.
        """
        noise = at_floor(self.models[-1].held_out, settings)
        if not self.steps:
            first = self.rungs[0].verdict
            return ("none" if noise else "unexplained") if first.effects and self.dropped else first.kind
        if not noise and self.closed(settings) < settings.least_named:
            return "unexplained"
        return "equivalent" if any(step.rivals for step in self.steps) else "named"

    def with_first_step(self) -> "Ladder":
        """The ladder with the effect that its first rung names, where it names one."""
        return replace(self, steps=(step_from(self.rungs[0]),) if self.rungs[0].verdict.effects else ())


def climb(
    bench: Bench,
    base: Explained,
    effects: Mapping[str, Effect],
    scales: Scales,
    compiled: mujoco.MjModel,
    *,
    most: int,
    watch: Watch,
) -> Ladder:
    """Climb from a fitted base until `none`, `unexplained` or `most` added effects.

    Where a rung leaves several effects inseparable the first goes on, and each later rung reconsiders: a rival that
    explains more beside what was added since takes its place, one that explains less is no rival any more. An effect
    without which the ladder's last model explains the held-out logs as well is dropped, for good. Where a rung names
    nothing but has an effect that is worth a trial, that goes on, and is judged when the climb is over, before the
    others: until then none is dropped, lest what is in doubt take the place of what is not. Where that leaves a model
    that was not judged before, the climb goes on from there; one that was judged had its one trial.

    Args:
        bench: data and settings.
        base: the calibrated model.
        effects: the catalogue.
        scales: size of the effects' bounds.
        compiled: the compiled nominal model.
        most: most effects that are added.
        watch: is told the number of candidates of each ranking and gives what is called with each label that is done.
    """
    ladder = Ladder((), base, ())
    while True:
        last = ladder.models[-1]
        found = candidates(last.model, effects, scales, compiled)
        placed = [effect for effect in found.placed if effect.label not in ladder.dropped]
        ranking = rank(bench, last, placed, watch(len(placed)))
        ladder = ladder.topped(ranking.base)
        rung = Rung(ranking.base, ranking.candidates, decide(*ranking, bench.evidence, bench.scored))
        ladder = replace(ladder, rungs=(*ladder.rungs, rung), refused={**found.refused, **ladder.refused})
        over = len(ladder.steps) >= most or not (rung.verdict.effects or rung.verdict.trial)
        if over and all(step.proven for step in ladder.steps):
            return ladder
        superfluous: tuple[str, ...] = ()
        steps = ladder.steps if over else reconsider(bench, ladder.base, (*ladder.steps, step_from(rung)))
        if over or all(step.proven for step in steps):
            steps, superfluous = prune(bench, ladder.base, steps)
        ladder = replace(ladder, steps=steps, dropped=(*ladder.dropped, *superfluous))
        if over and any(judged.base is ladder.models[-1] for judged in ladder.rungs):
            return ladder


def step_from(rung: Rung) -> Step:
    """The effect that a rung's verdict names first, or holds worth a trial, with its rivals; there must be one."""
    found, named = {c.effect.label: c for c in rung.ranking}, rung.verdict.effects
    chosen, *rivals = (found[label] for label in named or rung.verdict.trial)
    return Step(chosen.explained, tuple(rivals), proven=bool(named))


def reconsider(bench: Bench, base: Explained, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """Try every rival of an earlier effect in its place, beside all that was added since.

    A rival that was added itself since then stands beside the effect, not in its place.
    """
    for place, step in enumerate(steps[:-1]):
        for rival in step.rivals:
            added = {other.explained.model.effects[-1].label for k, other in enumerate(steps) if k != place}
            if rival.effect.label in added:
                steps = _without(steps, place, rival)
                continue
            swapped = _swap(bench, base, steps, place, rival)
            ours, theirs = steps[-1].explained.held_out, swapped[-1].explained.held_out
            if supported(paired_gain(ours, theirs, bench.evidence), 0, bench.evidence):
                steps = swapped
            elif supported(paired_gain(theirs, ours, bench.evidence), 0, bench.evidence):
                steps = _without(steps, place, rival)
    return steps


def prune(bench: Bench, base: Explained, steps: tuple[Step, ...]) -> tuple[tuple[Step, ...], tuple[str, ...]]:
    """Drop effects without which the logs are explained as well: those on trial first, of these the earliest first.

    Returns:
        The steps that stay, refitted and proven, and the labels of the effects that were dropped.
    """
    for place in sorted(range(len(steps)), key=lambda k: steps[k].proven):
        effect = steps[place].explained.model.effects[-1]
        fewer = _stacked(bench, base, steps[:place], steps[place + 1 :])
        fewer, base = _as_good_as_it_can(bench, base, fewer, steps[-1].explained)
        without = fewer[-1].explained if fewer else base
        gain = paired_gain(without.held_out, steps[-1].explained.held_out, bench.evidence)
        if not supported(gain, len(effect.parameters), bench.evidence):
            kept, dropped = prune(bench, base, fewer)
            return kept, (effect.label, *dropped)
    return tuple(replace(step, proven=True) for step in steps), ()


def _as_good_as_it_can(
    bench: Bench, base: Explained, fewer: tuple[Step, ...], whole: Explained
) -> tuple[tuple[Step, ...], Explained]:
    """Steps that lack one effect of a whole ladder, the last model fitted anew from where the whole ladder's ended."""
    last = fewer[-1].explained if fewer else base
    values = whole.values()
    start = np.array([values[name] for name in last.model.space.names])
    again = explain(bench, last.model, start, whole.fit.delta)
    if again.fit.order >= last.fit.order:
        return fewer, base
    return ((*fewer[:-1], replace(fewer[-1], explained=again)), base) if fewer else (fewer, again)


def _stacked(bench: Bench, base: Explained, below: Sequence[Step], above: Sequence[Step]) -> tuple[Step, ...]:
    """Steps on top of others than they stood on, refitted where that matters."""
    stacked = list(below)
    for step in above:
        ground = stacked[-1].explained if stacked else base
        stacked.append(replace(step, explained=_on(bench, ground, step.explained)))
    return tuple(stacked)


def _without(steps: tuple[Step, ...], place: int, rival: Candidate) -> tuple[Step, ...]:
    kept = tuple(r for r in steps[place].rivals if r is not rival)
    return (*steps[:place], replace(steps[place], rivals=kept), *steps[place + 1 :])


def _swap(bench: Bench, base: Explained, steps: Sequence[Step], place: int, rival: Candidate) -> tuple[Step, ...]:
    """The steps with a rival at one place, later models refitted; what it replaced explains less and is dropped."""
    others = tuple(r for r in steps[place].rivals if r is not rival)
    swapped = replace(steps[place], explained=rival.explained, rivals=others)
    return _stacked(bench, base, steps[:place], (swapped, *steps[place + 1 :]))


def _on(bench: Bench, below: Explained, explained: Explained) -> Explained:
    """The last effect of a fitted model on top of another model; refitted where that is not what it stood on."""
    *others, last = explained.model.effects
    if [e.label for e in others] == [e.label for e in below.model.effects]:
        return explained
    model, values = below.model.with_effect(last), explained.values() | below.values()
    start = model.space.vector({name: value for name, value in values.items() if name in model.space.names})
    return explain(bench, model, start, below.fit.delta)
