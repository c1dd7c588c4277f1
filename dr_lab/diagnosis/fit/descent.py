"""One descent of a fit by Levenberg–Marquardt, over batched simulations.

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
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.diagnosis.fit.states import polished
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.physics.straight import Straight
from dr_lab.trajectory import Array

_Models = tuple[NormalEquations, NormalEquations]
_Ended = tuple[int, bool, bool, bool]  # steps taken, whether converged, late, over
_WHOLE = np.ones(1)
STAY = (np.empty(0), np.empty(0))
_SHARES = 0.5 ** np.arange(5)  # of a step of bodies that are free as a whole, which are tried at once


class Descent:
    """Steps of Levenberg–Marquardt over one `Replay`.

    Args: as `Fitter`.
    """

    def __init__(self, replay: Replay, settings: SolverSettings, *, rough: bool = False, reach: Room = STAY) -> None:
        self.replay, self._rough, self.space = replay, rough, replay.model.space
        self._reach = [np.append(np.zeros(len(self.space.parameters) - len(far)), far) for far in reach]
        self.settings, self._objective = settings, Objective(replay, settings)
        ways = Straight.of(replay.model)
        self._straight = ways if replay.windows.loaded.all() else ways.apart()
        self._bodies = np.array([p.prior is not None for p in self.space.parameters], bool)
        self._needed = Fresh.MOST if rough else Fresh.PARAMETERS  # for the certificate

    def _descend(self, best: Point, known: Slopes | None, most: int, goal: float = np.inf) -> Fit:
        """Levenberg–Marquardt in the windows that the start can simulate; 0 steps only linearise."""
        settings, slopes = self.settings, FollowedSlopes(self.replay, self.settings, best, known)
        best, weight, first = self._objective.linear(best, slopes.now)
        linear, damping, taken, failed, pace = first, Damping(settings), 0, False, Pace(settings, best.cost)
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
            pace.add(best.cost, trial.cost)
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
        return self._fit(best, weight, (linear, first), slopes.now, (taken, converged, late, over), tuple(pace.costs))

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

    def _fit(
        self, at: Point, weight: Array, linear: _Models, slopes: Slopes, ended: _Ended, fallen: tuple[float, ...]
    ) -> Fit:
        """A fit that ends at a point, with the linear models there and at its start; the rest as `Fit` has it."""
        costs = np.where(at.infeasible, 0.0, self._objective.window_costs(at, weight))
        return Fit(at.z, at.delta, at.residuals, at.cost, at.infeasible, *linear, costs, slopes, *ended, fallen)

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
