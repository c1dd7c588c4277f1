"""Commands through a driver that keeps one number from step to step."""

from collections.abc import Callable
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.trajectory import Array

Advance = Callable[[Array, Array], tuple[Array, Array]]
"""Output at a step's start and the step's command to the step's average output and the output at its end."""


def filtered(series: Array, contexts: int, advance: Advance) -> Array:
    """Step averages of a driver's output; at the first known command it is taken to be at rest.

    Args:
        series: step averages of the commands, shape (c or 1, w, s).
        contexts: c.
        advance: one step of all contexts and windows, on arrays of shape (c or 1, w).

    Returns:
        Step averages of the output, shape (c, w, s).
    """
    averages = np.empty((contexts, *series.shape[1:]))
    level = series[:, :, 0]
    for step in range(series.shape[2]):
        averages[:, :, step], level = advance(level, series[:, :, step])
    return averages


@dataclass
class Driver(Law):
    """The same for commands that are not known ahead, in n simulations.

    Attributes:
        column: of the command in the controls.
        advance: one step of all simulations, on arrays of shape (n,).
        level: output at the end of the last step; NaN where there was none, shape (n,).
    """

    column: int
    advance: Advance
    level: Array = field(default_factory=lambda: np.empty(0), init=False)

    def act(self, moment: Moment, influence: Influence) -> None:
        """Let the step's average output take the command's place."""
        del moment
        asked = influence.control[:, self.column].copy()
        before = self.level if len(self.level) else np.full(len(asked), np.nan)
        level = np.where(np.isnan(before), asked, before)
        influence.control[:, self.column], self.level = self.advance(level, asked)

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Wait for the first command."""
        if len(self.level):
            self.level[rows] = np.nan

    @property
    def memory(self) -> Array:
        """The level."""
        return self.level[:, None].copy() if len(self.level) else np.empty((1, 0))

    def remember(self, memory: Array) -> None:
        """Go on from the `memory` of an equal driver."""
        self.level = memory[:, 0].copy() if memory.shape[1] else np.empty(0)


def column_of(compiled: mujoco.MjModel, actuator: str) -> int:
    """Column of an actuator's only command in the controls."""
    return int(compiled.actuator_ctrladr[compiled.actuator(actuator).id])
