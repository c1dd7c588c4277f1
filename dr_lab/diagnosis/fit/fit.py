"""What a fit of a model's context to windows of measurements ends with."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.slopes import Slopes
from dr_lab.physics.context import ContextSpace
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
        converged: whether the certificate holds: a full linear step would lower the cost by less than the tolerance;
            else only short steps lower the cost, or none.
        late: whether it ended because at its pace it would not have reached its goal.
        over: whether its last steps show that it gains nothing more: the last one raised the cost although all slopes
            had been taken where it ends, or they moved the cost by too little for any comparison.
        costs: at the start of its first descent, and the lowest after each of its steps.
    """

    equations: NormalEquations
    first: NormalEquations
    window_costs: Array
    slopes: Slopes
    iterations: int
    converged: bool
    late: bool = False
    over: bool = False
    costs: tuple[float, ...] = ()

    def after(self, steps: int) -> float:
        """The lowest cost after so many steps of the first descent, or after its last one."""
        return self.costs[: steps + 1][-1]

    def below(self, other: "Fit") -> float:
        """By how much the cost is below another fit's of the same windows, in those that neither lets diverge."""
        alone = self.window_costs[other.infeasible].sum() - other.window_costs[self.infeasible].sum()
        return other.cost - self.cost + float(alone)

    def made_up(self, space: ContextSpace, given: Mapping[str, float]) -> tuple[Array, Array]:
        """Context (n,) and states (w, s) with some parameters elsewhere, for which the others make up as best they can.

        By the linear model at the fit, within the bounds: a mass takes over from a payload that is taken away.

        Args:
            space: of the fit's model.
            given: values by full name.
        """
        unit, places = space.to_unit(self.z), [space.index(name) for name in given]
        moved, move = np.zeros(len(unit), bool), np.zeros(len(unit))
        moved[places] = True
        move[places] = space.to_unit(space.vector(given))[places] - unit[places]
        step, states = self.equations.made_up(moved, move, (np.minimum(-unit, 0.0), np.maximum(1.0 - unit, 0.0)))
        return space.clip(space.from_unit(unit + step)), self.delta + states

    def pick(self, rows: NDArray[np.intp]) -> "Fit":
        """The fit as seen in some windows, at the same context."""
        every = np.zeros(len(self.infeasible), bool)
        every[rows] = True
        return replace(
            self,
            delta=self.delta[rows],
            residuals=self.residuals[rows],
            cost=self.cost - float(self.window_costs[~every].sum()),
            infeasible=self.infeasible[rows],
            equations=self.equations.pick(rows),
            first=self.first.pick(rows),
            window_costs=self.window_costs[rows],
            slopes=self.slopes.pick(rows),
        )


def movable(unit: Array, gradient: Array) -> NDArray[np.bool_]:
    """Parameters that their bounds do not hold back; `unit` from 0 to 1 between the bounds, both of shape (n,)."""
    return ~(((unit <= 0) & (gradient > 0)) | ((unit >= 1) & (gradient < 0)))
