"""Rank the catalogue: every effect at every site.

Most candidates are out after a linear step on few windows. A fit to these windows decides between most of the others.
Only those that stand are fitted to all windows, so the cost hardly grows with the catalogue or the length of the logs.
"""

import functools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from threading import Event
from typing import NamedTuple, TypeVar

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fitted_alone, scored
from dr_lab.diagnosis.evidence.paired_gain import paired_gain, supported
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.identifiability import Identifiability
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.search.as_special_case import further, special_case
from dr_lab.diagnosis.search.candidate import Candidate, resolved
from dr_lab.diagnosis.search.screen import FirstLook, linear_gain, look
from dr_lab.diagnosis.search.shortlist import shortlist
from dr_lab.diagnosis.search.side_by_side import side_by_side
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_In = TypeVar("_In")
_Out = TypeVar("_Out")


class Ranking(NamedTuple):
    """Candidates beside one model.

    Attributes:
        base: the model without them; a better fit than the given one if a candidate's fit led to it.
        candidates: most evidence first, equal evidence by fewest parameters.
    """

    base: FittedModel
    candidates: tuple[Candidate, ...]


def rank(bench: Bench, base: FittedModel, placed: Sequence[PlacedEffect], done: Callable[[str], None]) -> Ranking:
    """Rank candidates beside a fitted model; `done` is told each label.

    1. Each is linearised at absent and at its further starts, on a part of the windows (`Bench.screening`).
    2. Those that promise enough are fitted there, half of them with a single parameter. If these gain less than
       promised, a second wave is fitted of those that promise about as much as the first gained.
    3. The best one and those that it does not beat there are fitted to all windows and scored on the held-out ones,
       except those that hardly explain more than a special case of theirs.
    4. The model without them is fitted anew from where the best of these ended, with the effect absent. If that is
       better than the base, it becomes the base, and candidates get no credit for it.

    If the base became better beyond doubt, all candidates are ranked anew beside it. They run side by side, one thread
    each, so that no core is asked for twice. A failure or Ctrl-C ends all of them at their next simulation.
    """
    ranking = _Contest(bench, base, placed, done).ranking()
    for _ in range(bench.solver.restarts):
        gained = paired_gain(base.held_out, ranking.base.held_out, bench.evidence)
        if not supported(gained, 0, bench.evidence):
            break
        base = ranking.base
        ranking = _Contest(bench, base, placed, done).ranking()
    return ranking


class _Contest:
    """One ranking under way."""

    def __init__(
        self, bench: Bench, base: FittedModel, placed: Sequence[PlacedEffect], done: Callable[[str], None]
    ) -> None:
        self.bench, self.base, self.placed, self.done = bench.beside(base), base, placed, done
        self.stop = Event()
        self.thin = self.bench.screening()
        self.start = base.fit if self.thin is self.bench else self._thinned()
        self.ground = base if self.thin is self.bench else fitted_alone(self._replay(self.thin), self.start)

    def ranking(self) -> Ranking:
        """All candidates, and the base that they are compared with."""
        return self.credited(self.final(self.tried()))

    def tried(self) -> dict[int, Candidate]:
        """All candidates by place; those that promise enough are fitted to the screening windows and scored."""
        settings = self.bench.evidence
        looks = self._side_by_side(range(len(self.placed)), self._look)
        promise = np.array([self.bench.promise(each.gain, self.start) for each in looks])
        self._ask_all_windows(promise, looks)
        order = [int(k) for k in np.argsort(-promise, kind="stable")]
        hopeful = [k for k in order if promise[k] >= self.bench.hope]
        found: dict[int, Candidate] = {}
        reachable = max((looks[k].gain for k in hopeful), default=0.0)
        for _ in range(2):
            near = [k for k in hopeful if looks[k].gain >= settings.least_promise * reachable]
            wave = shortlist([k for k in near if k not in found], self.placed, settings.most_fits - len(found))
            self._fit_wave(wave, looks, found)
            reachable = max((c.fitted_model.fit.below(self.start) for c in found.values()), default=0.0)
        for k in set(order) - found.keys():
            first, predicted = looks[k], looks[k].gain / self.start.cost
            found[k] = self._unfitted(self.placed[k], first.absent, first.identifiability, predicted)
            self.done(self.placed[k].label)
        return found

    def _fit_wave(self, wave: list[int], looks: Sequence[FirstLook], found: dict[int, Candidate]) -> None:
        """Fit some candidates. An effect waits for its special case, to which it may have nothing to add."""
        wave.sort(key=lambda k: -len(self.placed[k].parameters))  # those that take longest begin
        cases = self._special_cases(wave, sorted({*wave, *found}))
        self._do([k for k in wave if k not in cases], lambda k: self._try(k, looks[k]), found)
        self._do([*cases], lambda k: self._beside(k, looks[k], found[cases[k]]), found)

    def final(self, tried: dict[int, Candidate]) -> tuple[Candidate, ...]:
        """The candidates, most evidence first; those that stand are fitted to all windows."""
        if self.thin is not self.bench:
            standing = self._standing(tried)
            cases = self._special_cases(standing, standing)
            self._do([k for k in standing if k not in cases], lambda k: self._refit(tried[k]), tried)
            self._do([*cases], lambda k: self._refit_beside(tried[k], tried[cases[k]]), tried)
        return _ordered(tried.values())

    def _do(self, items: Sequence[int], work: Callable[[int], Candidate], found: dict[int, Candidate]) -> None:
        found |= dict(zip(items, self._side_by_side(items, work), strict=True))

    def _special_cases(self, richer: Sequence[int], among: Sequence[int]) -> dict[int, int]:
        """Place of an effect's special case among some others, by the effect's place; only where there is one."""
        cases = {k: special_case(self.placed[k], [self.placed[j] for j in among]) for k in richer}
        return {k: among[place] for k, place in cases.items() if place is not None}

    def credited(self, found: tuple[Candidate, ...]) -> Ranking:
        """The ranking, with the base fitted anew from where the best candidate's fit ended, if that is better."""
        settings = self.bench.evidence
        credited = [c for c in found if c.final and supported(c.gain, len(c.effect.parameters), settings)]
        best = min(credited, key=lambda c: c.fitted_model.fit.order, default=None)
        if best is None:
            return Ranking(self.base, found)
        best = min(self.base.fit, self._below(best), key=lambda fit: fit.order)
        if self.base.fit.cost - best.cost <= self.bench.solver.tolerance * best.cost:
            return Ranking(self.base, found)
        base = scored(self.bench, self.base.model, best, near=self.base.states)
        final = {
            c.effect.label: paired_gain(base.held_out, c.fitted_model.held_out, settings) for c in found if c.final
        }
        return Ranking(base, _ordered(replace(c, gain=final.get(c.effect.label, c.gain)) for c in found))

    def _below(self, candidate: Candidate) -> Fit:
        """The model without an effect, fitted from where the fit with it ended."""
        fit = candidate.fitted_model.fit
        fitter = Fitter(self._replay(self.bench), self.bench.solver)
        return fitter.rerun(fitter.begin(fit.z[: len(self.base.fit.z)], fit.delta), self.base.fit.cost)

    def _thinned(self) -> Fit:
        """The base fitted to the screening windows alone: an effect gets no credit for what only these windows ask."""
        part = self.base.fit.pick(self.bench.screened)
        return Fitter(self._replay(self.thin), self.bench.solver).run(part.z, part.delta, part.slopes)

    def _ask_all_windows(self, promise: Array, looks: Sequence[FirstLook]) -> None:
        """Look at all windows if the few promise something, but so little that it may be chance."""
        if self.thin is self.bench or promise.max(initial=0.0) > self.bench.enough:
            return
        unsure = [int(k) for k in np.flatnonzero(promise >= self.bench.hope)]
        promise[unsure] = self._side_by_side(unsure, lambda k: self._promise_of_all(k, looks[k]))

    def _promise_of_all(self, k: int, first: FirstLook) -> float:
        """What a candidate promises on all windows, linearised at the point where it promised most on the few."""
        fitter, base = self._fitter(self.bench, self.placed[k]), self.base.fit
        count = len(self.placed[k].parameters)
        z = np.append(base.z, first.best[-count:])
        (there,) = fitter.outlooks(z[None], base.delta, base.slopes)
        return self.bench.promise(linear_gain(fitter, there, base), base, count)

    def _look(self, k: int) -> FirstLook:
        return look(self._fitter(self.thin, self.placed[k]), self.placed[k], self.start)

    def _fitter(self, bench: Bench, effect: PlacedEffect) -> Fitter:
        rough = bench is self.thin and bench is not self.bench  # those that stand will be fitted again
        return Fitter(self._replay(bench, effect), bench.solver, rough=rough)

    def _replay(self, bench: Bench, *effects: PlacedEffect) -> Replay:
        return Replay(functools.reduce(Model.with_effect, effects, self.base.model), bench.fit, 1, self.stop)

    def _beside(self, k: int, first: FirstLook, poorer: Candidate) -> Candidate:
        """Fit a candidate from its special case if that explains much; go on only if a linear step promises more."""
        effect, case, settings = self.placed[k], poorer.effect, self.bench.evidence
        if self.thin is self.bench or not supported(poorer.gain, len(case.parameters), settings):
            return self._try(k, first)
        fitter, (there, more) = self._fitter(self.thin, effect), self._further(self.thin, effect, poorer)
        found = fitter.run(there.z, there.delta, there.slopes) if more else there
        self.done(effect.label)
        return self._rough_candidate(fitter, effect, found, first)

    def _further(self, bench: Bench, effect: PlacedEffect, poorer: Candidate) -> tuple[Fit, bool]:
        """An effect at the fit of its special case, and whether a linear step from there promises enough."""
        fit, extra = poorer.fitted_model.fit, len(effect.parameters) - len(poorer.effect.parameters)
        there = further(self._fitter(bench, effect), effect, poorer.effect, fit, poorer.fitted_model.values())
        beside = self.bench.beside(poorer.fitted_model)
        return there.fit, beside.promise(there.gain, fit, extra) >= beside.hope

    def _try(self, k: int, first: FirstLook) -> Candidate:
        """Fit one candidate from the base's solution and from its further starts.

        A short run shows whether a start away from absent is worth going on from.
        """
        effect, base = self.placed[k], self.start
        fitter = self._fitter(self.thin, effect)
        fits = [fitter.run(first.absent.z, base.delta, base.slopes)]
        steps = self.bench.solver.start_iterations * effect.effect.patience
        for z in first.starts:
            start = fitter.begin(z, base.delta)
            rough = fitter.run(z, start.delta, base.slopes, steps)
            if rough.order < min(f.order for f in fits):
                fits.append(fitter.run(rough.z, rough.delta))
        fit = min(fits, key=lambda f: f.order)
        self.done(effect.label)
        if self.thin is self.bench:
            return self._candidate(effect, fit, first.identifiability, first.gain / base.cost)
        return self._rough_candidate(fitter, effect, fit, first)

    def _rough_candidate(self, fitter: Fitter, effect: PlacedEffect, fit: Fit, first: FirstLook) -> Candidate:
        fitted_model = fitted_alone(fitter.replay, fit)
        gain = paired_gain(self.ground.held_out, fitted_model.held_out, self.bench.evidence)
        return Candidate(effect, fitted_model, gain, first.identifiability, first.gain / self.start.cost, final=False)

    def _refit(self, candidate: Candidate) -> Candidate:
        """A candidate fitted to all windows, or left absent if it does not gain enough there.

        An effect that acts at once and promises little begins at absent, where the base's slopes are known.
        """
        effect, base, fit = candidate.effect, self.base.fit, candidate.fitted_model.fit
        fitter, goal = self._fitter(self.bench, effect), self.bench.hoped(base)
        nominal = np.append(base.z, [p.nominal for p in effect.parameters])
        (absent,) = fitter.outlooks(nominal[None], base.delta, base.slopes, base)
        if not effect.starts and self.bench.promise(linear_gain(fitter, absent, base), base) < self.bench.enough:
            again = fitter.run(nominal, base.delta, absent.slopes, goal=goal)
        else:
            delta = base.delta.copy()
            delta[self.bench.screened] = fit.delta
            again = fitter.rerun(fitter.begin(fit.z, delta), goal)
        if again.cost > goal:
            absent = replace(absent, slopes=base.slopes)  # to save memory
            return self._unfitted(effect, absent, candidate.identifiability, candidate.predicted)
        return self._candidate(effect, again, candidate.identifiability, candidate.predicted)

    def _refit_beside(self, candidate: Candidate, poorer: Candidate) -> Candidate:
        """The same for an effect whose special case stands: the fit begins there, if that promises and gains enough."""
        if not poorer.final:
            return self._refit(candidate)
        there, more = self._further(self.bench, candidate.effect, poorer)
        if not more:
            return candidate
        fitter, beside = self._fitter(self.bench, candidate.effect), self.bench.beside(poorer.fitted_model)
        goal = beside.hoped(poorer.fitted_model.fit)
        again = fitter.run(there.z, there.delta, there.slopes, goal=goal)
        if again.cost > goal:
            return candidate
        return self._candidate(candidate.effect, again, candidate.identifiability, candidate.predicted)

    def _candidate(self, effect: PlacedEffect, fit: Fit, known: Identifiability, predicted: float) -> Candidate:
        model = self.base.model.with_effect(effect)
        fitted_model = scored(self.bench, model, fit, 1, self.base.states, self.stop)
        gain = paired_gain(self.base.held_out, fitted_model.held_out, self.bench.evidence)
        seen = resolved(effect, fitted_model.values(), self.bench.timing_resolution)
        return Candidate(effect, fitted_model, gain, known, predicted, resolved=seen)

    def _unfitted(self, effect: PlacedEffect, absent: Fit, known: Identifiability, predicted: float) -> Candidate:
        """A candidate that stays absent and so equals the base."""
        base = self.base
        fitted_model = FittedModel(base.model.with_effect(effect), absent, base.states, base.held_out, base.apart)
        gain = paired_gain(base.held_out, base.held_out, self.bench.evidence)
        return Candidate(effect, fitted_model, gain, known, predicted, False, False)

    def _standing(self, tried: dict[int, Candidate]) -> list[int]:
        """Places of the best candidates and of all that the best one does not beat."""
        settings = self.bench.evidence
        order = sorted((k for k, c in tried.items() if c.fitted), key=lambda k: -tried[k].gain.total)
        if not order:
            return []
        standing: list[int] = []
        for k in sorted(order, key=lambda k: len(tried[k].effect.parameters)):
            best = paired_gain(tried[k].fitted_model.held_out, tried[order[0]].fitted_model.held_out, settings)
            cases = [j for j in standing if self._special_cases([k], [j])]  # others may lead on few windows alone
            needless = any(self._needless(tried[k], tried[j]) for j in cases or standing)
            if not needless and not supported(best, 0, settings):
                standing.append(k)
        return standing

    def _needless(self, candidate: Candidate, other: Candidate) -> bool:
        """Whether a candidate with more parameters than another one hardly explains more."""
        more = len(candidate.effect.parameters) - len(other.effect.parameters)
        if more <= 0:
            return False
        ours, theirs = candidate.fitted_model.fit, other.fitted_model.fit
        return self.bench.beside(other.fitted_model).promise(ours.below(theirs), theirs, more) < self.bench.hope

    def _side_by_side(self, items: Sequence[_In], work: Callable[[_In], _Out]) -> list[_Out]:
        return side_by_side(items, work, self.bench.threads, self.stop)


def _ordered(candidates: Iterable[Candidate]) -> tuple[Candidate, ...]:
    return tuple(sorted(candidates, key=lambda c: (-c.gain.total, len(c.effect.parameters))))
