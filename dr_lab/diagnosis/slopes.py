"""Finite differences of residuals: columns of the Jacobian, simulated as one batch."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.point import Point
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Slopes:
    """Jacobian of the residuals.

    Attributes:
        state: ∂r/∂δ by window, shape (w, m, s).
        parameter: ∂r/∂θ in unit-cube parameters, shape (w, m, p).
    """

    state: Array
    parameter: Array

    def pick(self, rows: NDArray[np.intp]) -> "Slopes":
        """The slopes of some windows."""
        return Slopes(self.state[rows], self.parameter[rows])


def differences(
    replay: Replay, settings: SolverSettings, point: Point, *, states: bool, columns: NDArray[np.intp]
) -> Array:
    """Forward differences for the start states (if wanted) and the given parameters.

    A parameter in the upper half of its bounds steps down, so no column leaves them. Windows that diverge in a column
    get zeros there.

    Args:
        replay: windows and model.
        settings: sizes of the steps.
        point: where.
        states: whether to differentiate by the start states.
        columns: parameters to differentiate by.

    Returns:
        Columns, states first, shape (w, m, columns).
    """
    space = replay.model.space
    unit = space.to_unit(point.z)
    state_steps = settings.state_step * replay.windows.prior.std if states else np.zeros(0)
    unit_steps = np.where(unit[columns] > 0.5, -1.0, 1.0) * settings.parameter_step
    count = len(state_steps) + len(unit_steps)
    if not count:
        return np.zeros((*point.residuals.shape, 0))
    units, deltas = np.tile(unit, (count, 1)), np.tile(point.delta, (count, 1, 1))
    for i, step in enumerate(state_steps):
        deltas[i, :, i] += step
    for j, (column, step) in enumerate(zip(columns, unit_steps, strict=True)):
        units[len(state_steps) + j, column] += step
    most = max(1, settings.batch // len(point.residuals))
    parts = [
        replay.residuals(space.from_unit(units[first : first + most]), deltas[first : first + most])
        for first in range(0, count, most)
    ]
    moved, infeasible = (np.concatenate(rows) for rows in zip(*parts, strict=True))
    slopes = (moved - point.residuals) / np.concatenate([state_steps, unit_steps])[:, None, None]
    slopes[infeasible] = 0.0
    return slopes.transpose(1, 2, 0)
