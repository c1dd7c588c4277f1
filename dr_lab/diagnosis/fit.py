"""Fit of a model's context to windows of measurements by Levenberg–Marquardt over batched simulations.

Unknowns are the context z and, as nuisance, every window's initial state x_w with a Gaussian prior around its
smoothed measurement (multiple shooting, MAP). The cost is
Σ_w ‖(y − ŷ(z, x_w))/σ‖²_Huber + Σ_w ‖(x_w − x̄_w)/s‖² + ‖(z − z_nominal)/(k · span)‖².
All columns of the Jacobian are one batch of simulations; the states are eliminated by a Schur complement.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.normal_equations import NormalEquations
from dr_lab.diagnosis.point import Point, better_start, huber_weights, window_costs
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.slopes import Slopes, differences
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Fit(Point):
    """The point at which the cost is lowest.

    Attributes:
        equations: Gauss–Newton model at the point, with the slopes of the last linearisation, in unit-cube parameters.
        first: the same at the start.
        window_costs: cost of each window, zero where it diverges, shape (w,).
        slopes: Jacobian at the last linearisation.
        iterations: steps taken.
        converged: whether the last step, hardly damped, lowered the cost by less than the tolerance, with every window
            that the result can simulate; else the iterations ran out, or only short steps lower the cost, or none.
    """

    equations: NormalEquations
    first: NormalEquations
    window_costs: Array
    slopes: Slopes
    iterations: int
    converged: bool

    @property
    def order(self) -> tuple[int, float]:
        """What makes one fit of the same windows better than another: fewer that diverge, then a lower cost."""
        return int(self.infeasible.sum()), self.cost

    def below(self, other: "Fit") -> float:
        """By how much the cost is below another fit's of the same windows, in those that neither lets diverge."""
        alone = self.window_costs[other.infeasible].sum() - other.window_costs[self.infeasible].sum()
        return other.cost - self.cost + float(alone)


class Fitter:
    """Levenberg–Marquardt over one `Replay`.

    Args:
        replay: windows and model.
        settings: step sizes and stopping rule.
    """

    def __init__(self, replay: Replay, settings: SolverSettings) -> None:
        self.replay = replay
        self.settings = settings
        self.space = replay.model.space
        self._columns = np.arange(len(self.space.parameters))
        self._precision = replay.windows.prior.std**-2.0
        self._prior_precision = np.full(len(self._columns), settings.prior_spans**-2.0)

    def run(
        self, z: Array, delta: Array | None = None, known: Slopes | None = None, iterations: int | None = None
    ) -> Fit:
        """Fit from a start.

        Windows that diverge at the start are left out. Those that the result can simulate come back, and the fit goes
        on with them, `settings.restarts` times at most.

        Args:
            z: start, shape (n,).
            delta: first state corrections, shape (w, nstate); None starts at the prior's mean.
            known: slopes at the start for the states and the first parameters, which need no simulation then.
            iterations: most steps before windows come back; None takes the settings', 0 only linearises.
        """
        if delta is None:
            delta = np.zeros((len(self.replay.windows), self.replay.nstate))
        most = self.settings.iterations if iterations is None else iterations
        fit, left = self._descend(self._point(z, delta), known, most), self.settings.restarts
        while most and (start := self._with_returned(fit)):
            if not left:
                return replace(fit, converged=False)
            again, left = self._descend(start, None, most), left - 1
            fit = replace(again, first=fit.first, iterations=fit.iterations + again.iterations)
        return fit

    def _with_returned(self, fit: Fit) -> Point | None:
        """The fit's result with windows that were left out and can be simulated there; None where there are none."""
        if not fit.infeasible.any():
            return None
        start = self.begin(fit.z, fit.delta)
        return start if (fit.infeasible & ~start.infeasible).any() else None

    def _descend(self, best: Point, known: Slopes | None, most: int) -> Fit:
        """Levenberg–Marquardt in the windows that the start can simulate."""
        settings = self.settings
        slopes, stale = self._first_slopes(best, known), known is not None
        best, weight, linear = self._linear(best, slopes)
        first, damping, taken, converged = linear, settings.damping, 0, False
        for taken in range(1, most + 1):
            trial = self._trial(best, linear, damping, weight)
            gain = best.cost - trial.cost
            if gain >= 0:
                done = gain <= settings.tolerance * best.cost
                converged = done and damping <= settings.hardly_damped and not best.infeasible.all()
                stale = gain <= settings.refresh * best.cost
                best, damping, known = trial, damping / settings.damping_down, None
                if done or taken == most:
                    break
                slopes = self._slopes(best, state=slopes.state if stale else None)
            elif stale:
                slopes, stale = self._slopes(best, parameter=slopes.parameter if known is None else None), False
            else:
                damping *= settings.damping_up
                if damping > settings.damping_max:
                    break
                continue
            best, weight, linear = self._linear(best, slopes)
        best, weight, linear = self._linear(best, slopes)
        costs = np.where(best.infeasible, 0.0, window_costs(best, weight, self._precision))
        ended = (linear, first, costs, slopes, taken, converged)
        return Fit(best.z, best.delta, best.residuals, best.cost, best.infeasible, *ended)

    def begin(self, z: Array, delta: Array) -> Point:
        """A start: in each window the given state correction, or none where that fits better.

        Args:
            z: context, shape (n,).
            delta: state corrections that were fitted at another context, shape (w, nstate).
        """
        mean = self._point(z, np.zeros_like(delta))
        weight = huber_weights(mean.residuals, self.replay.fitted, mean.infeasible, self.settings.huber)
        return better_start(mean, self._point(z, delta), weight, self._precision)

    def _first_slopes(self, point: Point, known: Slopes | None) -> Slopes:
        if known is None:
            return self._slopes(point)
        given = known.parameter.shape[2]
        rest = self._differences(point, states=False, columns=self._columns[given:])
        return Slopes(known.state, np.concatenate([known.parameter, rest], axis=2))

    def _slopes(self, point: Point, state: Array | None = None, parameter: Array | None = None) -> Slopes:
        """Slopes at a point; given may be those of the states from nearby, or of the parameters from the same point."""
        wanted = self._columns if parameter is None else self._columns[:0]
        columns = self._differences(point, states=state is None, columns=wanted)
        count = self.replay.nstate if state is None else 0
        return Slopes(
            columns[..., :count] if state is None else state, columns[..., count:] if parameter is None else parameter
        )

    def _differences(self, point: Point, *, states: bool, columns: NDArray[np.intp]) -> Array:
        return differences(self.replay, self.settings, point, states=states, columns=columns)

    def _linear(self, point: Point, slopes: Slopes) -> tuple[Point, Array, NormalEquations]:
        """The point with its cost under fresh robust weights, the weights, and the normal equations there."""
        weight = huber_weights(point.residuals, self.replay.fitted, point.infeasible, self.settings.huber)
        unit = self.space.to_unit(point.z) - self.space.to_unit(self.space.nominal)
        equations = NormalEquations.build(
            residual=point.residuals,
            state_jacobian=slopes.state,
            parameter_jacobian=slopes.parameter,
            weight=weight,
            delta=point.delta,
            state_precision=self._precision,
            prior=self._prior_precision,
            prior_gradient=self._prior_precision * unit,
        )
        return replace(point, cost=self._cost(point, weight)), weight, equations

    def _point(self, z: Array, delta: Array) -> Point:
        residuals, infeasible = self.replay.residuals(z[None], delta[None])
        return Point(z, delta, residuals[0], np.inf, infeasible[0])

    def _cost(self, point: Point, weight: Array) -> float:
        offset = self.space.to_unit(point.z) - self.space.to_unit(self.space.nominal)
        states = float((self._precision * point.delta**2).sum())
        prior = float((self._prior_precision * offset**2).sum())
        return float((weight * point.residuals**2).sum()) + states + prior

    def _trial(self, best: Point, linear: NormalEquations, damping: float, weight: Array) -> Point:
        unit = self.space.to_unit(best.z)
        gradient = linear.window_information()[1].sum(0) + linear.prior_gradient
        movable = ~(((unit <= 0) & (gradient > 0)) | ((unit >= 1) & (gradient < 0)))
        move, state_move = linear.step(damping, movable)
        unit = np.clip(unit + move, 0, 1)
        trial = self._point(self.space.from_unit(unit), best.delta + state_move)
        if (trial.infeasible & ~best.infeasible).any():
            return trial
        return replace(trial, cost=self._cost(trial, weight), infeasible=best.infeasible | trial.infeasible)
