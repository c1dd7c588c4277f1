"""Fits of the candidates beside one model to a part of the windows."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from threading import Event
from typing import TypeVar

import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench, FittedModel, fitted_alone, scored
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.evidence.paired_gain import Gain, paired_gain
from dr_lab.diagnosis.evidence.support import supported
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.identifiability import Identifiability
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.normal_equations import Decrease
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.diagnosis.search import as_special_case
from dr_lab.diagnosis.search.candidate import Candidate, resolved
from dr_lab.diagnosis.search.screen import FirstLook, linear_gain, look, own_step
from dr_lab.diagnosis.search.side_by_side import one_behind_another, side_by_side
from dr_lab.diagnosis.search.taken_away import taken_away
from dr_lab.diagnosis.search.wider import reach, widened
from dr_lab.effects.effect import PlacedEffect
from dr_lab.trajectory import Array

_In = TypeVar("_In")
_Out = TypeVar("_Out")


class CandidateFits:
    """How candidates beside one model are fitted and scored, each on one thread.

    Args:
        bench: all windows, beside the model.
        base: the model without the candidates.

    Attributes:
        thin: the part of the windows (`Bench.screening`).
        start: the base's fit to the part: an effect gets no credit for what only these windows ask.
        stop: set to end all fits at their next simulation.
    """

    def __init__(self, bench: Bench, base: FittedModel) -> None:
        self.bench, self.base = bench, base
        self.stop = Event()
        self.thin = bench.screening(base.fit)
        self.start = base.fit if self.whole else self._thinned()
        self._ground = base if self.whole else fitted_alone(self._replay(self.thin), self.start)

    @property
    def whole(self) -> bool:
        """Whether the part of the windows is all of them, so that nothing is fitted twice."""
        return self.thin is self.bench

    def side_by_side(self, items: Sequence[_In], work: Callable[[_In], _Out]) -> list[_Out]:
        """What the work gives for each item, in their order; see the function of that name."""
        return side_by_side(items, work, self.bench.threads, self.stop)

    def of(self, places: Sequence[int], work: Callable[[int], Candidate]) -> dict[int, Candidate]:
        """The same for candidates, by their place."""
        return dict(zip(places, self.side_by_side(places, work), strict=True))

    def behind(
        self, places: Sequence[int], before: Mapping[int, int], work: Callable[[int, Candidate | None], Candidate]
    ) -> dict[int, Candidate]:
        """The same where some wait for a candidate at another place; see `one_behind_another`."""
        return dict(zip(places, one_behind_another(places, before, work, self.bench.threads, self.stop), strict=True))

    def threads_of(self, count: int) -> int:
        """Threads of each of so many fits that run side by side."""
        return max(1, self.bench.threads // max(count, 1))

    def look(self, effect: PlacedEffect) -> FirstLook:
        """An effect linearised on the part of the windows."""
        return look(self.fitter(self.thin, effect), effect, self.start, self._alone)

    @cached_property
    def _alone(self) -> Decrease:
        """What a step of the base alone would gain on the part of the windows."""
        return own_step(self.start, self.base.model.space)

    def promise_of_all(self, effect: PlacedEffect, first: FirstLook) -> float:
        """What a candidate promises on all windows, linearised at the point where it promised most on the few.

        Where that is absent, the base's residuals are known.
        """
        fitter, base = self.fitter(self.bench, effect), self.base.fit
        count, z = len(effect.parameters), first.best.copy()
        stay = first.best[:-count] == first.absent.z[:-count]  # a start may let other effects be absent
        z[:-count][stay] = base.z[stay]
        absent = np.array_equal(first.best, first.absent.z)
        (there,) = fitter.outlooks(z[None], base.delta, base.slopes, base if absent else None)
        return self.bench.promise(linear_gain(fitter, there, base, self.base.model.space), base, count)

    def goal(self, found: Sequence[Candidate]) -> float:
        """Cost on the part of the windows above which a candidate is beaten without a doubt; ∞ if none is fitted."""
        if not found:
            return np.inf
        best = min((candidate.fitted_model.fit for candidate in found), key=lambda fit: fit.order)
        return self.thin.cost_at(best, self.bench.enough)

    def fitted(
        self,
        effect: PlacedEffect,
        first: FirstLook,
        goal: float = np.inf,
        threads: int = 1,
        limit: Candidate | None = None,
    ) -> Candidate:
        """Fit one candidate from the base's solution and from its further starts.

        Where what it is like in a `limit` explains something, it begins there and not at the base's. A short run shows
        whether a start away from absent is worth going on from: whether it is as low as the first fit was after as many
        steps, wherever that ended, unless that leaves noise. Bodies that are free as a whole begin as in the model
        file: those of a base that leaves more than noise have gone far to make up for what it lacks, along ways that
        bend. Of a `goal` see `Fitter.run`. One that is fitted while no other is may have more `threads`.
        """
        fitter = self.fitter(self.thin, effect, threads)
        helps = limit is not None and supported(limit.gain, len(limit.effect.parameters), self.bench.evidence)
        if self.base.model.inertials and not at_floor(self.base.held_out, self.bench.evidence):
            fit = self._of_bodies(fitter, effect, first, goal)
        elif limit is not None and helps and not self.whole:
            fit = self._of_starts(fitter, effect, first, goal, self._in_the_limit(fitter, effect, first, limit))
        else:
            fit = self._of_starts(fitter, effect, first, goal, first.absent)
        if self.whole:
            return self.candidate(effect, fit, first.identifiability, first.gain / self.start.cost)
        return self._rough_candidate(fitter, effect, fit, first)

    def _of_starts(self, fitter: Fitter, effect: PlacedEffect, first: FirstLook, goal: float, there: Fit) -> Fit:
        base = self.start
        best = near = fitter.go_on(there, goal)
        steps = self._short(effect)
        for z in first.starts:
            start = fitter.begin(z, base.delta)
            rough = fitter.run(z, start.delta, base.slopes, steps)
            as_fast = rough.order <= (best.order[0], near.after(steps))
            if rough.order < best.order or (as_fast and not self._leaves_noise(fitter, best)):
                again = fitter.run(rough.z, rough.delta, goal=min(goal, best.cost))
                best = min(best, again, key=lambda fit: fit.order)
        return best

    def _leaves_noise(self, fitter: Fitter, fit: Fit) -> bool:
        return at_floor(fitted_alone(fitter.replay, fit).held_out, self.bench.evidence)

    def _in_the_limit(self, fitter: Fitter, effect: PlacedEffect, first: FirstLook, limit: Candidate) -> Fit:
        """An effect linearised where that which it is like in a limit ended, at the best of its own shapes."""
        space, fit, values = fitter.space, limit.fitted_model.fit, limit.fitted_model.values()
        own = map(space.mapping, (first.absent.z, *first.starts))
        contexts = np.stack([as_special_case.in_the_limit(effect, limit.effect, space, each, values) for each in own])
        known = Slopes(fit.slopes.state, fit.slopes.parameter[..., : len(self.start.z)])
        found = fitter.outlooks(np.unique(contexts, axis=0), fit.delta, known)
        return min(found, key=lambda each: each.order)

    def _short(self, effect: PlacedEffect) -> int:
        """Steps of the short run from a start."""
        solver = self.bench.solver
        steps = solver.start_iterations * effect.effect.patience
        return steps * solver.rolling_patience if self.thin.fit.prior.grounded else steps

    def _of_bodies(self, fitter: Fitter, effect: PlacedEffect, first: FirstLook, goal: float) -> Fit:
        """The best of all starts after few steps, gone on with: where bodies are free, all starts are far away."""
        steps = self._short(effect)
        begun = (fitter.begin(self._as_filed(z), self.start.delta) for z in (first.absent.z, *first.starts))
        rough = min(
            (fitter.run(each.z, each.delta, iterations=steps, goal=goal) for each in begun), key=lambda f: f.order
        )
        return fitter.run(rough.z, rough.delta, goal=goal)

    def _as_filed(self, z: Array) -> Array:
        """A context of the base and an effect, with free bodies as in the model file."""
        space, filed = self.base.model.space, z.copy()
        for name in (p.name for body in self.base.model.inertials for p in body.parameters):
            filed[space.index(name)] = space.nominal[space.index(name)]
        return filed

    def fitted_beside(self, effect: PlacedEffect, first: FirstLook, poorer: Candidate) -> Candidate:
        """Fit a candidate from its special case if that explains much; go on only if a linear step promises more.

        One that does not act there as the special case does is fitted from its own starts, unless noise is all that is
        left to explain.
        """
        case, settings = poorer.effect, self.bench.evidence
        if self.whole or not supported(poorer.gain, len(case.parameters), settings):
            return self.fitted(effect, first)
        further = self.further(self.thin, effect, poorer)
        if further is None:
            noise = at_floor(poorer.fitted_model.held_out, settings)
            return self.unfitted(effect, first) if noise else self.fitted(effect, first)
        fitter, (there, more) = self.fitter(self.thin, effect), further
        found = fitter.go_on(there) if more else there
        return self._rough_candidate(fitter, effect, found, first)

    def farther(self, candidate: Candidate, threads: int = 1) -> Candidate | None:
        """A candidate whose bounds were moved that its fit ran into, gone on with; None where none may be moved."""
        effect, fit = candidate.effect, candidate.fitted_model.fit
        bench = self.bench if candidate.final else self.thin
        wide = widened(effect, fit.z[len(fit.z) - len(effect.parameters) :], bench.fit)
        if wide is None:
            return None
        fitter = self.fitter(bench, wide, threads)
        found = fitter.run(fit.z, fit.delta)
        if candidate.final:
            return self.candidate(wide, found, candidate.identifiability, candidate.predicted, threads)
        fitted_model = fitted_alone(fitter.replay, found)
        gain = paired_gain(self._ground.held_out, fitted_model.held_out, self.bench.evidence)
        return replace(candidate, effect=wide, fitted_model=fitted_model, gain=gain)

    def unfitted(self, effect: PlacedEffect, first: FirstLook) -> Candidate:
        """An effect that promises too little to be fitted."""
        return self.at_absent(effect, first.absent, first.identifiability, first.gain / self.start.cost)

    def without(self, candidate: Candidate) -> Fit:
        """The model without an effect, fitted from where the fit with it ended; the base's fit where that is as good.

        Where bodies are free, whose slopes are dear, few windows tell first whether a better one can be reached.
        """
        if self.base.model.inertials and not self.whole:
            rows = self.bench.screened(self.base.fit)
            part = replace(candidate.fitted_model, fit=candidate.fitted_model.fit.pick(rows))
            if self._without(self.thin, part, self.start).order >= self.start.order:
                return self.base.fit
        return min(
            self.base.fit, self._without(self.bench, candidate.fitted_model, self.base.fit), key=lambda f: f.order
        )

    def _without(self, bench: Bench, whole: FittedModel, base: Fit) -> Fit:
        replay = Replay(self.base.model, bench.fit, self.bench.threads, self.stop)  # nothing runs beside it
        fitter = Fitter(replay, bench.solver)
        return fitter.rerun(*taken_away(fitter, whole), goal=base.cost)

    def _thinned(self) -> Fit:
        part = self.base.fit.pick(self.bench.screened(self.base.fit))
        return Fitter(self._replay(self.thin), self.bench.solver).run(part.z, part.delta, part.slopes)

    def further(self, bench: Bench, effect: PlacedEffect, poorer: Candidate) -> tuple[Fit, bool] | None:
        """An effect at the fit of its special case, and whether a linear step from there promises enough.

        None where it explains less there than the special case: that it holds it is true only nearly.
        """
        fit, extra = poorer.fitted_model.fit, len(effect.parameters) - len(poorer.effect.parameters)
        there = as_special_case.further(
            self.fitter(bench, effect), effect, poorer.effect, fit, poorer.fitted_model.values()
        )
        beside = self.bench.beside(poorer.fitted_model)
        if beside.promise(there.fit.cost - fit.cost, there.fit) >= beside.hope:
            return None
        return there.fit, beside.promise(there.gain, fit, extra) >= beside.hope

    def _rough_candidate(self, fitter: Fitter, effect: PlacedEffect, fit: Fit, first: FirstLook) -> Candidate:
        fitted_model = fitted_alone(fitter.replay, fit)
        gain = paired_gain(self._ground.held_out, fitted_model.held_out, self.bench.evidence)
        predicted, seen = first.gain / self.start.cost, self.thin.fit
        return Candidate(effect, fitted_model, gain, first.identifiability, predicted, seen, final=False)

    def candidate(
        self, effect: PlacedEffect, fit: Fit, known: Identifiability, predicted: float, threads: int = 1
    ) -> Candidate:
        """A candidate that is fitted to all windows."""
        model = self.base.model.with_effect(effect)
        fitted_model = scored(self.bench, model, fit, threads, self.base.states, self.stop)
        gain = paired_gain(self.base.held_out, fitted_model.held_out, self.bench.evidence)
        seen = resolved(effect, fitted_model.values(), self.bench.timing_resolution)
        return Candidate(effect, fitted_model, gain, known, predicted, self.bench.fit, resolved=seen)

    def at_absent(self, effect: PlacedEffect, absent: Fit, known: Identifiability, predicted: float) -> Candidate:
        """A candidate that stays absent and so equals the base."""
        base = self.base
        fitted_model = FittedModel(base.model.with_effect(effect), absent, base.states, base.held_out, base.apart)
        return Candidate(effect, fitted_model, self._nothing, known, predicted, self.bench.fit, False, False)

    @cached_property
    def _nothing(self) -> Gain:
        """What the base gains over itself."""
        return paired_gain(self.base.held_out, self.base.held_out, self.bench.evidence)

    def fitter(self, bench: Bench, effect: PlacedEffect, threads: int = 1) -> Fitter:
        """Of the model with an effect, to the windows of a bench; rough on the part of the windows.

        Bounds may be moved after a fit to that part, and after one to all.
        """
        rough = bench is self.thin and not self.whole  # those that stand will be fitted again
        far = reach(effect, bench.fit, bench.evidence.widenings if bench is self.thin else 0)
        model = self.base.model.with_effect(effect)
        return Fitter(Replay(model, bench.fit, threads, self.stop), bench.solver, rough=rough, reach=far)

    def _replay(self, bench: Bench) -> Replay:
        return Replay(self.base.model, bench.fit, 1, self.stop)
