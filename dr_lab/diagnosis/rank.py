"""Rank the catalogue: every effect at every site, looked at, tried where worth it, fitted and scored where it stands.

Most candidates are out after a linear step on few windows; a fit of these windows decides between most of the others;
only those that stand are fitted to all windows. So the cost hardly grows with the catalogue or the length of the logs.
"""

import functools
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from threading import Event
from typing import NamedTuple, TypeVar

import numpy as np

from dr_lab.diagnosis.bench import Bench, Explained, fitted_alone, scored
from dr_lab.diagnosis.evidence import Gain, paired_gain, supported
from dr_lab.diagnosis.fit import Fit, Fitter
from dr_lab.diagnosis.identifiability import Identifiability
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.screen import Look, look
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.effects.effect import PlacedEffect
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

_In = TypeVar("_In")
_Out = TypeVar("_Out")


@dataclass(frozen=True)
class Candidate:
    """One effect at one site, compared with the same model without it.

    Attributes:
        effect: the placed effect.
        explained: the model with the effect; of one that is not final, fitted to and scored on a part of the windows.
        gain: paired gain over the model without it, on the windows that score it.
        identifiability: what the data can say of it.
        predicted: share of the cost on the fit windows that a linear step could remove.
        fitted: whether the effect was fitted; else it stayed absent, as its prediction was too small.
        final: whether it was fitted to all windows; else another candidate had beaten it on a part of them, or
            explained as much with fewer parameters.
        resolved: whether it is more than a shift in time by less than `Bench.timing_resolution`; an integrator's own
            error is such a shift, and so is what a command that is logged too rarely leaves.
    """

    effect: PlacedEffect
    explained: Explained
    gain: Gain
    identifiability: Identifiability
    predicted: float
    fitted: bool = True
    final: bool = True
    resolved: bool = True


class Ranking(NamedTuple):
    """Candidates beside one model.

    Attributes:
        base: the model without them; better than the one that was given where a candidate's fit showed the way.
        candidates: most evidence first, equal evidence by fewest parameters.
    """

    base: Explained
    candidates: tuple[Candidate, ...]


def rank(bench: Bench, base: Explained, placed: Sequence[PlacedEffect], done: Callable[[str], None]) -> Ranking:
    """Rank candidates beside a fitted model; `done` is told each label.

    1. Each is linearised at absent and at its further starts, on a part of the windows (`Bench.screening`).
    2. Those that promise enough are fitted there, half of them with a single parameter; where they gain less than
       promised, so are those whose promise stands up to that.
    3. The best of them, and what it does not beat there, are fitted to all windows and scored on the held-out ones;
       of those that explain as much, the ones with the fewest parameters.
    4. The model without them is fitted anew from where the best of these ended, with the effect absent. Where that is
       better than the base, it is the base, and candidates get no credit for it.

    A base that became better beyond doubt is ranked beside anew. Candidates run side by side, one thread each, so that
    no core is asked for twice. A failure or Ctrl-C ends all of them at their next simulation.
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
        self, bench: Bench, base: Explained, placed: Sequence[PlacedEffect], done: Callable[[str], None]
    ) -> None:
        self.bench, self.base, self.placed, self.done = bench, base, placed, done
        self.stop = Event()
        self.thin = bench.screening()
        self.start = base.fit if self.thin is bench else self._thinned()
        self.ground = base if self.thin is bench else fitted_alone(self._replay(self.thin), self.start)
        self.samples = sum(int(s.fitted.sum()) * s.channel.size for s in bench.fit.samples)

    def ranking(self) -> Ranking:
        """All candidates, and the base that they are compared with."""
        return self.credited(self.final(self.tried()))

    def tried(self) -> dict[int, Candidate]:
        """All candidates by place, those that promise enough fitted to the screening windows and scored."""
        settings = self.bench.evidence
        looks = self._side_by_side(range(len(self.placed)), lambda k: self._look(self.thin, self.start, k))
        promise = np.array([self._promise(each.gain, self.start) for each in looks])
        self._ask_all_windows(promise)
        order = [int(k) for k in np.argsort(-promise, kind="stable")]
        hopeful = [k for k in order if promise[k] >= settings.least_hope * settings.threshold]
        found: dict[int, Candidate] = {}
        reachable = max((looks[k].gain for k in hopeful), default=0.0)
        for _ in range(2):
            near = [k for k in hopeful if looks[k].gain >= settings.least_promise * reachable]
            wave = _shortlist([k for k in near if k not in found], self.placed, settings.most_fits - len(found))
            wave.sort(key=lambda k: -len(self.placed[k].parameters))  # those that take longest begin
            found |= dict(zip(wave, self._side_by_side(wave, lambda k: self._try(k, looks[k])), strict=True))
            reachable = max((c.explained.fit.below(self.start) for c in found.values()), default=0.0)
        for k in set(order) - found.keys():
            found[k] = self._unfitted(k, looks[k])
            self.done(self.placed[k].label)
        return found

    def final(self, tried: dict[int, Candidate]) -> tuple[Candidate, ...]:
        """The candidates, those that stand fitted to all windows; the most evidence first."""
        if self.thin is not self.bench:
            standing = self._standing(tried)
            tried |= dict(zip(standing, self._side_by_side(standing, lambda k: self._refit(tried[k])), strict=True))
        return _ordered(tried.values())

    def credited(self, found: tuple[Candidate, ...]) -> Ranking:
        """The ranking beside the best that the model without the effects can do from where their fits ended."""
        settings = self.bench.evidence
        credited = [c for c in found if c.final and supported(c.gain, len(c.effect.parameters), settings)]
        best = min(credited, key=lambda c: c.explained.fit.order, default=None)
        if best is None:
            return Ranking(self.base, found)
        best = min(self.base.fit, self._below(best), key=lambda fit: fit.order)
        if self.base.fit.cost - best.cost <= self.bench.solver.tolerance * best.cost:
            return Ranking(self.base, found)
        base = scored(self.bench, self.base.model, best, near=self.base.states)
        final = {c.effect.label: paired_gain(base.held_out, c.explained.held_out, settings) for c in found if c.final}
        return Ranking(base, _ordered(replace(c, gain=final.get(c.effect.label, c.gain)) for c in found))

    def _below(self, candidate: Candidate) -> Fit:
        """The model without an effect, fitted from where the fit with it ended."""
        fit = candidate.explained.fit
        fitter = Fitter(self._replay(self.bench), self.bench.solver)
        z = fit.z[: len(self.base.fit.z)]
        return fitter.run(z, fitter.polish(z, fit.delta).delta)

    def _thinned(self) -> Fit:
        """The base fitted to the screening windows alone, so that an effect gets no credit for what they alone ask."""
        part = self.base.fit.pick(self.bench.screened)
        return Fitter(self._replay(self.thin), self.bench.solver).run(part.z, part.delta, part.slopes)

    def _promise(self, gain: float, base: Fit) -> float:
        """Evidence on all windows that a lower cost foretells, −n ln(1 − share): Δχ² of residuals of unknown size."""
        return -self.samples * float(np.log1p(-np.clip(gain / base.cost, 0.0, 1.0 - 1e-9)))

    def _ask_all_windows(self, promise: Array) -> None:
        """Look at all windows where few promise something, but not much."""
        settings = self.bench.evidence
        least, enough = settings.least_hope * settings.threshold, settings.enough_hope * settings.threshold
        if self.thin is self.bench or promise.max(initial=0.0) > enough:
            return
        unsure = [int(k) for k in np.flatnonzero(promise >= least)]
        for k, each in zip(unsure, self._side_by_side(unsure, self._look_at_all), strict=True):
            promise[k] = self._promise(each.gain, self.base.fit)

    def _look_at_all(self, k: int) -> Look:
        return self._look(self.bench, self.base.fit, k)

    def _look(self, bench: Bench, base: Fit, k: int) -> Look:
        return look(self._fitter(bench, self.placed[k]), self.placed[k], base)

    def _fitter(self, bench: Bench, effect: PlacedEffect) -> Fitter:
        return Fitter(self._replay(bench, effect), bench.solver)

    def _replay(self, bench: Bench, *effects: PlacedEffect) -> Replay:
        return Replay(functools.reduce(Model.with_effect, effects, self.base.model), bench.fit, 1, self.stop)

    @property
    def _rough(self) -> SolverSettings:
        """How candidates are fitted that will be fitted again, if they stand."""
        solver = self.bench.solver
        return solver if self.thin is self.bench else replace(solver, tolerance=solver.rough_tolerance)

    def _try(self, k: int, first: Look) -> Candidate:
        """Fit one candidate from the base's solution and from its further starts.

        A short run shows whether a start away from absent is worth going on from.
        """
        effect, base = self.placed[k], self.start
        fitter = Fitter(self._replay(self.thin, effect), self._rough)
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
        explained = fitted_alone(fitter.replay, fit)
        gain = paired_gain(self.ground.held_out, explained.held_out, self.bench.evidence)
        return Candidate(effect, explained, gain, first.identifiability, first.gain / base.cost, final=False)

    def _refit(self, candidate: Candidate) -> Candidate:
        """A candidate fitted to all windows, from where its fit of some of them ended."""
        fit = candidate.explained.fit
        fitter = self._fitter(self.bench, candidate.effect)
        delta = self.base.fit.delta.copy()
        delta[self.bench.screened] = fit.delta
        again = fitter.run(fit.z, fitter.polish(fit.z, delta).delta)
        return self._candidate(candidate.effect, again, candidate.identifiability, candidate.predicted)

    def _candidate(self, effect: PlacedEffect, fit: Fit, known: Identifiability, predicted: float) -> Candidate:
        model = self.base.model.with_effect(effect)
        explained = scored(self.bench, model, fit, 1, self.base.states, self.stop)
        gain = paired_gain(self.base.held_out, explained.held_out, self.bench.evidence)
        return Candidate(effect, explained, gain, known, predicted, resolved=self._resolved(effect, explained))

    def _resolved(self, effect: PlacedEffect, explained: Explained) -> bool:
        if any(p.unit != "s" for p in effect.parameters):
            return True
        values, least = explained.values(), self.bench.timing_resolution
        return any(abs(values[p.name] - p.nominal) >= least for p in effect.parameters)

    def _unfitted(self, k: int, first: Look) -> Candidate:
        """A candidate that stays absent, where it is the base."""
        base, effect = self.base, self.placed[k]
        explained = Explained(base.model.with_effect(effect), first.absent, base.states, base.held_out, base.apart)
        gain = paired_gain(base.held_out, base.held_out, self.bench.evidence)
        return Candidate(effect, explained, gain, first.identifiability, first.gain / self.start.cost, False, False)

    def _standing(self, tried: dict[int, Candidate]) -> list[int]:
        """Places of the best candidates and of all that the best one does not beat."""
        settings = self.bench.evidence
        order = sorted((k for k, c in tried.items() if c.fitted), key=lambda k: -tried[k].gain.total)
        if not order:
            return []
        standing: list[int] = []
        for k in sorted(order, key=lambda k: len(tried[k].effect.parameters)):
            best = paired_gain(tried[k].explained.held_out, tried[order[0]].explained.held_out, settings)
            needless = any(self._needless(tried[k], tried[other]) for other in standing)
            if not needless and not supported(best, 0, settings):
                standing.append(k)
        return standing

    def _needless(self, candidate: Candidate, other: Candidate) -> bool:
        """Whether a candidate with more parameters than another one hardly explains more."""
        more = len(candidate.effect.parameters) - len(other.effect.parameters)
        if more <= 0:
            return False
        settings, ours, theirs = self.bench.evidence, candidate.explained.fit, other.explained.fit
        chance = settings.penalty * more * theirs.cost / (self.samples * len(theirs.delta) / len(self.base.fit.delta))
        return self._promise(ours.below(theirs) - chance, theirs) < settings.least_hope * settings.threshold

    def _side_by_side(self, items: Sequence[_In], work: Callable[[_In], _Out]) -> list[_Out]:
        with ThreadPoolExecutor(self.bench.threads) as pool:
            jobs = [pool.submit(work, item) for item in items]
            try:
                for job in as_completed(jobs):
                    job.result()
            except BaseException:
                self.stop.set()
                pool.shutdown(cancel_futures=True)
                raise
        return [job.result() for job in jobs]


def _ordered(candidates: Iterable[Candidate]) -> tuple[Candidate, ...]:
    return tuple(sorted(candidates, key=lambda c: (-c.gain.total, len(c.effect.parameters))))


def _shortlist(order: Sequence[int], placed: Sequence[PlacedEffect], most: int) -> list[int]:
    """Of candidates in the order of their promise at most so many: those first, and as many with one parameter.

    Whatever holds another effect promises at least as much; it must not take the simpler one's place.
    """
    half = order[: (most + 1) // 2]
    simple = [k for k in order if len(placed[k].parameters) == 1 and k not in half]
    return list(dict.fromkeys([*half, *simple[: most // 2], *order]))[:most]
