"""The cost that a fit lowers, and how much of it is worth a step."""

from dataclasses import replace

import numpy as np

from dr_lab.diagnosis.fit.correlation import colour
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.point import Point, window_costs
from dr_lab.diagnosis.fit.prior import prior_precision
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.trajectory import Array


class Objective:
    """Σ_w ‖(y − ŷ(z, x_w))/σ‖²_Huber + Σ_w ‖(x_w − x̄_w)/s‖² + ‖(z − z_nominal)/(k · span)‖².

    Args:
        replay: windows and model.
        settings: robustness, weak prior and tolerance.

    Attributes:
        states: precision of the prior of a window's state, shape (nstate,).
    """

    def __init__(self, replay: Replay, settings: SolverSettings) -> None:
        self._replay, self._settings, self._space = replay, settings, replay.model.space
        self._noise = float(replay.fitted.sum())  # the cost that noise alone leaves
        self.states = replay.windows.prior.std**-2.0
        self._prior = prior_precision(self._space, settings)

    def point(self, z: Array, delta: Array) -> Point:
        """A context (n,) with state corrections (w, nstate), simulated; of unknown cost."""
        residuals, infeasible = self._replay.residuals(z[None], delta[None])
        return Point(z, delta, residuals[0], np.inf, infeasible[0])

    def weights(self, point: Point) -> Array:
        """Huber weights of its residuals, shape (w, m)."""
        return self._replay.weights(point.residuals, point.infeasible, self._settings.huber)

    def cost(self, point: Point, weight: Array) -> float:
        """The cost under such weights."""
        states = float((self.states * point.delta**2).sum())
        prior = float((self._prior * self._offset(point) ** 2).sum())
        return float((weight * point.residuals**2).sum()) + states + prior

    def window_costs(self, point: Point, weight: Array) -> Array:
        """The cost of every window with the prior of its state, shape (w,)."""
        return window_costs(point, weight, self.states)

    def linear(self, point: Point, slopes: Slopes) -> tuple[Point, Array, NormalEquations]:
        """The point with its cost under fresh robust weights, the weights, and the normal equations there."""
        weight = self.weights(point)
        equations = NormalEquations.build(
            residual=point.residuals,
            state_jacobian=slopes.state,
            parameter_jacobian=slopes.parameter,
            weight=weight,
            delta=point.delta,
            state_precision=self.states,
            prior=self._prior,
            prior_gradient=self._prior * self._offset(point),
        )
        return replace(point, cost=self.cost(point, weight)), weight, equations

    def negligible(self, point: Point, deviance: float) -> float:
        """By how much the cost may fall while the deviance n ln(cost) falls by less than so much.

        n is the number of independent residuals. Where a model leaves more than noise they are few and large, and the
        parameters' standard deviations grow by the root of both. At the noise floor it is the deviance itself.
        """
        used = (self._replay.fitted & ~point.infeasible[:, None]).astype(float)
        parts = zip(*(self._replay.by_channel(rows) for rows in (point.residuals, used)), strict=True)
        alike = colour((residual, mask > 0) for (_, residual), (_, mask) in parts)
        return deviance * max(alike * point.cost / max(self._noise, 1.0), 1.0)

    def rough(self, point: Point) -> float:
        """The share of the cost that is enough for fits that only decide which candidates are fitted again."""
        return self._settings.rough_tolerance * max(point.cost, self._noise)

    def _offset(self, point: Point) -> Array:
        return self._space.to_unit(point.z) - self._space.to_unit(self._space.nominal)
