"""Fit of a model's context to windows of measurements: descents by Levenberg–Marquardt until the fit has converged."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from dr_lab.diagnosis.fit.descent import Descent
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.point import Point, better_start
from dr_lab.diagnosis.fit.slopes import Slopes, quick_around, quick_differences
from dr_lab.diagnosis.fit.states import restarted
from dr_lab.trajectory import Array


class Fitter(Descent):
    """Levenberg–Marquardt over one `Replay`.

    Args:
        replay: windows and model.
        settings: step sizes and stopping rule.
        rough: whether the fits only decide which candidates are fitted again: then `settings.rough_tolerance` is the
            share of the cost that is not worth a step, and a descent that crawls on in such steps ends.
        reach: how far the bounds of the last parameters may be moved later, in their widths, below and above, shape
            (k,) each; what is foretold of a goal counts with that.
    """

    def run(
        self,
        z: Array,
        delta: Array | None = None,
        known: Slopes | None = None,
        iterations: int | None = None,
        goal: float = np.inf,
    ) -> Fit:
        """Fit from a start until the certificate of convergence holds.

        The certificate is that a full linear step within the bounds, with fresh slopes by the parameters, would lower
        the deviance by less than `settings.tolerance` (`Objective.negligible`). A descent that ends without it, because
        only steps shorter and shorter help, begins anew from its end, with states and slopes taken anew, as long as
        that gains `settings.crawl_tolerance`, unless it is over: its last step failed with such slopes, or it crawls (a
        rough fit, whose steps are worth more, begins anew then). Windows that diverge at the start are left out; those
        that the result can simulate come back. Either happens `settings.restarts` times at most.

        Args:
            z: start, shape (n,).
            delta: first state corrections, shape (w, nstate); None starts at the prior's mean.
            known: slopes at the start for the states and the first parameters, which need no simulation then.
            iterations: most steps of a rough fit, which is not gone on with; None goes on to the certificate, 0 only
                linearises.
            goal: a cost; a fit ends, without the certificate, where a linear step foretells that it would stay above,
                a rough one after its first step (the slope at absent tells little of a long lag). It begins anew only
                once where at its pace it would not get there in the steps that it has left.
        """
        if delta is None:
            delta = np.zeros((len(self.replay.windows), self.replay.nstate))
        if iterations is not None:
            return self._descend(self._objective.point(z, delta), known, iterations, goal)
        return self._certified(self._objective.point(z, delta), known, goal)

    def go_on(self, there: Fit, goal: float = np.inf) -> Fit:
        """Fit from where the model was linearised, whose residuals and slopes are known; `goal` as in `run`."""
        start = Point(there.z, there.delta, there.residuals, np.inf, there.infeasible)
        return self._certified(start, there.slopes, goal)

    def rerun(self, *starts: Point, goal: float = np.inf) -> Fit:
        """Fit from the best of starts whose states were fitted elsewhere, as `begin` gives them; `goal` as in `run`."""
        return self._certified(*self.settled(*starts), goal)

    def rerun_below(self, start: Point, there: Fit, below: float, goal: float = np.inf) -> Fit:
        """`rerun` from a start whose cost is below so much once its states are fitted, else `go_on` from a fit."""
        here = self.settled(start)
        lost = (here[0].infeasible & ~there.infeasible).any()
        return self.go_on(there, goal) if lost or here[0].cost >= below else self._certified(*here, goal)

    def settled(self, *starts: Point) -> tuple[Point, Slopes]:
        """The best of starts with their states fitted, so that their costs tell something, and the slopes by these."""
        return min(map(self._settled, starts), key=lambda each: each[0].order)

    def _settled(self, start: Point) -> tuple[Point, Slopes]:
        state = quick_differences(self.replay, self.settings, start, states=True, columns=np.arange(0))
        point, slopes = self._polished(start, Slopes(state, state[..., :0]))
        return replace(point, cost=self._objective.cost(point, self._objective.weights(point))), slopes

    @cached_property
    def _narrow(self) -> "Fitter | None":
        """The same by the narrowest steps; None where steps are no wider."""
        if not self.replay.windows.prior.grounded or self.settings.rolling == 1.0:
            return None
        found = Fitter(self.replay, replace(self.settings, rolling=1.0), rough=self._rough)
        found._reach = self._reach
        return found

    def _certified(self, start: Point, known: Slopes | None, goal: float) -> Fit:
        """As `run`. Where steps are wide, narrow ones go on from where they end, and by turns as long as that gains."""
        fit, other, one = self._ended(start, known, goal), self._narrow, self
        while other is not None and fit.over and not self._misses(fit, fit.equations, goal):
            here = Point(fit.z, fit.delta, fit.residuals, np.inf, fit.infeasible)
            again = other._ended(here, None, goal)
            gains = again.below(fit) > self._worth(fit)[1]
            taken, best = fit.iterations + again.iterations, again if again.order <= fit.order else fit
            fit, other, one = replace(best, first=fit.first, iterations=taken, costs=fit.costs), one, other
            if not gains:
                break
        return fit

    def _ended(self, start: Point, known: Slopes | None, goal: float) -> Fit:
        fit, left = self._descend(start, known, self.settings.iterations, goal), self.settings.restarts
        left = 0 if self._rough and self._bodies.any() else left  # a descent among bodies' bounds is dear, and goes on
        while anew := self._anew(fit, goal):
            left = min(left, 1) if fit.late else left
            if not left:
                return replace(fit, converged=False)
            again, left = self._descend(anew, None, self.settings.iterations, goal), left - 1
            taken = fit.iterations + again.iterations
            gains = again.below(fit) > self._worth(fit)[1]
            if not (again.infeasible.sum() < fit.infeasible.sum() or gains):
                return replace(fit, iterations=taken)
            fit = replace(again, first=fit.first, iterations=taken, costs=fit.costs)
        return fit

    def _anew(self, fit: Fit, goal: float) -> Point | None:
        """Where a fit goes on: with windows that come back, or because it did not converge; None where it is done.

        One that is over is done, too, unless windows stray whose states end lower from elsewhere.
        """
        if self._misses(fit, fit.equations, goal):
            return None
        if (fit.converged or fit.over) and not fit.infeasible.any():
            return self._recovered(fit)
        start = self.begin(fit.z, fit.delta)
        returned = bool((fit.infeasible & ~start.infeasible).any())
        return start if returned or (not fit.converged and not fit.infeasible.all()) else None

    def _recovered(self, fit: Fit) -> Point | None:
        """A fit with the states of straying windows sought from their prior's mean; None where that gains too little.

        A window that misses an impact or sticks where the machine slides outweighs all others, which pay for it.
        """
        stray = fit.window_costs > self.settings.stray * float(np.median(fit.window_costs))
        if not stray.any():
            return None
        found = restarted(self.replay, self.settings, fit, fit.slopes.state, stray)
        start = replace(found, cost=self._objective.cost(found, self._objective.weights(found)))
        return start if fit.cost - start.cost > self._worth(fit)[1] else None

    def outlooks(self, z: Array, delta: Array, known: Slopes, first: Point | None = None) -> list[Fit]:
        """Linear models at several contexts with states that were fitted nearby, simulated as one batch.

        Args:
            z: contexts, shape (c, n).
            delta: state corrections, shape (w, nstate).
            known: slopes for the states and the first parameters, which need no simulation then.
            first: with the residuals at the first context, where it is the one of another model.
        """
        columns = np.arange(known.parameter.shape[2], len(self.space.parameters))
        found = quick_around(self.replay, self.settings, z, delta, columns, first)
        fits = list[Fit]()
        for context, residuals, infeasible, rest in zip(z, *found, strict=True):
            slopes = Slopes(known.state, np.concatenate([known.parameter, rest], axis=2))
            start = Point(context, delta, residuals, np.inf, infeasible)
            point, weight, linear = self._objective.linear(start, slopes)
            fits.append(self._fit(point, weight, (linear, linear), slopes, (0, False, False, False), (point.cost,)))
        return fits

    def begin(self, z: Array, delta: Array) -> Point:
        """A start, with its cost: in each window the given state correction, or none where that fits better.

        Args:
            z: context, shape (n,).
            delta: state corrections that were fitted at another context, shape (w, nstate).
        """
        mean = self._objective.point(z, np.zeros_like(delta))
        start = better_start(
            mean, self._objective.point(z, delta), self._objective.weights(mean), self._objective.states
        )
        return replace(start, cost=self._objective.cost(start, self._objective.weights(start)))
