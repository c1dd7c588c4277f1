"""Fit of a model's context to windows of measurements by Levenberg–Marquardt over batched simulations.

Unknowns are the context z and, as nuisance, every window's initial state x_w with a Gaussian prior around its
smoothed measurement (multiple shooting, MAP). `Objective` is the cost. The Jacobian is one batch of simulations.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.damping import Damping
from dr_lab.diagnosis.fit.fit import Fit, movable
from dr_lab.diagnosis.fit.followed_slopes import FollowedSlopes, Fresh
from dr_lab.diagnosis.fit.normal_equations import NormalEquations, Room
from dr_lab.diagnosis.fit.objective import Objective
from dr_lab.diagnosis.fit.pace import Pace
from dr_lab.diagnosis.fit.point import Point, better_start
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes, quick_around, quick_differences
from dr_lab.diagnosis.fit.states import polished, restarted
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.physics.straight import Straight
from dr_lab.trajectory import Array

_Models = tuple[NormalEquations, NormalEquations]
_WHOLE = np.ones(1)
_STAY = (np.empty(0), np.empty(0))
_SHARES = 0.5 ** np.arange(5)  # of a step of bodies that are free as a whole, which are tried at once


class Fitter:
    """Levenberg–Marquardt over one `Replay`.

    Args:
        replay: windows and model.
        settings: step sizes and stopping rule.
        rough: whether the fits only decide which candidates are fitted again: then `settings.rough_tolerance` is the
            share of the cost that is not worth a step, and a descent that crawls on in such steps ends.
        reach: how far the bounds of the last parameters may be moved later, in their widths, below and above, shape
            (k,) each; what is foretold of a goal counts with that.
    """

    def __init__(self, replay: Replay, settings: SolverSettings, *, rough: bool = False, reach: Room = _STAY) -> None:
        self.replay, self._rough, self.space = replay, rough, replay.model.space
        self._reach = [np.append(np.zeros(len(self.space.parameters) - len(far)), far) for far in reach]
        self.settings, self._objective = settings, Objective(replay, settings)
        ways = Straight.of(replay.model)
        self._straight = ways if replay.windows.loaded.all() else ways.apart()
        self._bodies = np.array([p.prior is not None for p in self.space.parameters], bool)
        self._needed = Fresh.MOST if rough else Fresh.PARAMETERS  # for the certificate

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
        return min(map(self._settled, starts), key=lambda each: (int(each[0].infeasible.sum()), each[0].cost))

    def _settled(self, start: Point) -> tuple[Point, Slopes]:
        state = quick_differences(self.replay, self.settings, start, states=True, columns=np.arange(0))
        point, slopes = self._polished(start, Slopes(state, state[..., :0]))
        return replace(point, cost=self._objective.cost(point, self._objective.weights(point))), slopes

    def _certified(self, start: Point, known: Slopes | None, goal: float) -> Fit:
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
            fit = replace(again, first=fit.first, iterations=taken)
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

    def _worth(self, point: Point) -> tuple[float, float]:
        """By how much a full step, and several steps in a row, must lower the cost to be worth their time."""
        settings, known = self.settings, self._objective.negligible(point, 1.0)
        least = max(settings.tolerance * known, self._objective.rough(point) if self._rough else 0.0)
        return least, least if self._rough else max(settings.crawl_tolerance * known, least)

    def _misses(self, point: Point, linear: NormalEquations, goal: float) -> bool:
        """Whether a linear step, which foretells a share of what can be gained, leaves a cost above the goal."""
        if point.cost <= goal or point.infeasible.any():
            return False
        predicted = linear.decrease(*self._free(point, linear, *self._reach))
        return point.cost - predicted / self.settings.foreseen > goal

    def _descend(self, best: Point, known: Slopes | None, most: int, goal: float = np.inf) -> Fit:
        """Levenberg–Marquardt in the windows that the start can simulate; 0 steps only linearise."""
        settings, slopes = self.settings, FollowedSlopes(self.replay, self.settings, best, known)
        best, weight, first = self._objective.linear(best, slopes.now)
        linear, damping, taken, failed, pace = first, Damping(settings), 0, False, Pace(settings)
        while True:
            predicted = linear.decrease(*self._free(best, linear))
            least, slow = self._worth(best)
            done = predicted <= least and not best.infeasible.all()
            converged = done and (slopes.fresh >= self._needed or taken == 0)  # given slopes are those of the start
            crawls = pace.crawls(slow)
            short = damping.largest or 2 * predicted < least * damping.now or crawls
            late = pace.too_slow(best.cost - goal, settings.iterations - taken)
            late &= not (converged or best.infeasible.any())
            given_up = (taken or not self._rough) and self._misses(best, linear, goal)
            if converged or taken >= most or (short and not done) or late or given_up:
                break
            if done:
                slopes.renew(best, Fresh.PARAMETERS)
                best, weight, linear = self._objective.linear(best, slopes.now)
                continue
            taken += 1
            trial, share, foretold = self._trial(best, linear, damping.now, weight)
            trial, nearby = self._mended(best, trial, slopes.now, weight, foretold)
            gain = best.cost - trial.cost
            pace.add(gain)
            failed = gain < 0 and slopes.fresh == Fresh.ALL
            if failed:
                damping.after_failure()
                continue
            if gain < 0:
                slopes.renew(best, Fresh.ALL)
            else:
                asked = slopes.asked(gain, foretold) if taken < most else Fresh.NONE  # nobody asks at the end
                damping.after_success(share, held_back=not asked and foretold < settings.foretold * predicted)
                slopes.follow(best, trial, nearby, asked)
                best = trial
            best, weight, linear = self._objective.linear(best, slopes.now)
            if self._rough and 0 <= gain <= least:
                break
        over = failed or (crawls and not self._rough)
        return self._fit(best, weight, (linear, first), slopes.now, taken, converged, late, over)

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
            fits.append(self._fit(point, weight, (linear, linear), slopes, 0, False))
        return fits

    def _fit(self, at: Point, weight: Array, linear: _Models, slopes: Slopes, taken: int, *ended: bool) -> Fit:
        """A fit that ends at a point, with the linear models there and at its start; the rest as `Fit` has it."""
        costs = np.where(at.infeasible, 0.0, self._objective.window_costs(at, weight))
        return Fit(at.z, at.delta, at.residuals, at.cost, at.infeasible, *linear, costs, slopes, taken, *ended)

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

    def _polished(self, point: Point, slopes: Slopes) -> tuple[Point, Slopes]:
        found = polished(self.replay, self.settings, point, slopes.state, ~point.infeasible)
        point = replace(point, delta=found.delta, residuals=found.residuals, infeasible=found.infeasible)
        return point, Slopes(found.slopes, slopes.parameter)

    def _mended(
        self, best: Point, trial: Point, slopes: Slopes, weight: Array, predicted: float
    ) -> tuple[Point, Slopes]:
        """A hindered trial with the states of those windows fitted anew, each on its own, that became worse.

        Where few windows meet a kink (a joint that sticks), all others would have to go in short steps. Where shapes
        touch, or a linear step foretells little, that costs more than it saves.
        """
        hindered = best.cost - trial.cost < self.settings.hindered * predicted and np.isfinite(trial.cost)
        if not hindered or self.replay.touching or predicted < self._objective.negligible(best, self.settings.mended):
            return trial, slopes
        worse = self._objective.window_costs(trial, weight) > self._objective.window_costs(best, weight)
        found = polished(self.replay, self.settings, trial, slopes.state, worse & ~trial.infeasible)
        point = replace(trial, delta=found.delta, residuals=found.residuals)
        return replace(point, cost=self._objective.cost(point, weight)), Slopes(found.slopes, slopes.parameter)

    def _free(
        self, point: Point, linear: NormalEquations, below: Array | float = 0.0, above: Array | float = 0.0
    ) -> tuple[NDArray[np.bool_], Room]:
        """Parameters that no bound holds back, and how far they may move, with bounds so many widths farther out."""
        gradient, unit = linear.slope, self.space.to_unit(point.z)
        free = movable((unit + below) / (1.0 + below + above), gradient)
        return free, (np.minimum(-below - unit, 0.0), np.maximum(1.0 + above - unit, 0.0))

    def _trial(self, best: Point, linear: NormalEquations, damping: float, weight: Array) -> tuple[Point, float, float]:
        """The point after a damped step, the share of it that this is, and what is foretold of it.

        The share is 1, or with bodies that which fits best: their ways bend among their bounds, within which only a
        share may lie, and few simulations more tell which.
        """
        move, state_move = linear.step(damping, *self._free(best, linear))
        shares = _WHOLE if self._straight.plain else _SHARES
        z = np.stack([self._end(best, share * move) for share in shares])
        delta = best.delta + shares[:, None, None] * state_move
        found = list[tuple[Point, float]]()
        for each, share in zip(zip(z, delta, *self.replay.residuals(z, delta), strict=True), shares, strict=True):
            trial = Point(*each[:3], np.inf, each[3])
            if not (trial.infeasible & ~best.infeasible).any():
                cost, lost = self._objective.cost(trial, weight), best.infeasible | trial.infeasible
                trial = replace(trial, cost=cost, infeasible=lost)
            found.append((trial, float(share)))
        trial, share = min(found, key=lambda each: each[0].cost)
        return trial, share, linear.foretold(share * move, share * state_move)

    def _end(self, point: Point, move: Array) -> Array:
        """The context to which a move in the unit cube leads, bodies along their straight ways, within the bounds."""
        if self._straight.plain:
            return self.space.from_unit(np.clip(self.space.to_unit(point.z) + move, 0, 1))
        return self.space.clip(self._straight.end(point.z, self.space.span * move))
