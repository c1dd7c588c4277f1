"""Command filters whose law is written once: for a recorded series, and step by step for a policy."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.physics.effect_parts import StepwiseFilter
from dr_lab.physics.law import CommandLaw, Influence, Law, Moment
from dr_lab.trajectory import Array

Advance = Callable[[Array, Array], tuple[Array, Array]]
"""Output at a step's start and the step's command to the step's average output and the output at its end."""


class StaticFilter(StepwiseFilter):
    """A filter without memory: its output is a function of the step's command alone."""

    @abstractmethod
    def output(self, values: Mapping[str, Array], asked: Array) -> Array:
        """What becomes of commands; the values broadcast with them."""

    def filtered(self, values: Mapping[str, Array], series: Array, option: mujoco.MjOption) -> Array:
        """All steps at once."""
        del option
        return self.output(values, series)

    def driver(self, values: Mapping[str, Array], column: int, step: float) -> Law:
        """One step after the other."""
        del step
        return StaticDriver(column, lambda asked: self.output(values, asked))


class DynamicFilter(StepwiseFilter):
    """A filter that keeps one number from step to step: its output at the end of the last one."""

    @abstractmethod
    def advance(self, values: Mapping[str, Array], step: float) -> Advance:
        """The law of one step of length `step` in s; the values broadcast with commands and outputs."""

    def filtered(self, values: Mapping[str, Array], series: Array, option: mujoco.MjOption) -> Array:
        """Step averages of the output; at the first known command the filter is taken to be at rest."""
        rows = {name: value[..., 0] for name, value in values.items()}
        advance, contexts = self.advance(rows, option.timestep), max(len(row) for row in rows.values())
        averages = np.empty((max(contexts, len(series)), *series.shape[1:]))
        level = series[:, :, 0]
        for step in range(series.shape[2]):
            averages[:, :, step], level = advance(level, series[:, :, step])
        return averages

    def driver(self, values: Mapping[str, Array], column: int, step: float) -> Law:
        """The same, one command at a time."""
        return DynamicDriver(column, self.advance(values, step))


@dataclass(frozen=True)
class StaticDriver(CommandLaw):
    """A filter without memory in n simulations.

    Attributes:
        column: of the command in the controls.
        output: commands of all simulations to outputs, shape (n,) both.
    """

    column: int
    output: Callable[[Array], Array]

    def act(self, moment: Moment, influence: Influence) -> None:
        """Let the output take the command's place."""
        del moment
        influence.control[:, self.column] = self.output(influence.control[:, self.column])


@dataclass
class DynamicDriver(CommandLaw):
    """A filter that keeps one number, in n simulations.

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
