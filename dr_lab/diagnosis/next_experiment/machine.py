"""The machine on which an experiment is to be played: where it starts, what it keeps, how it is seen."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.next_experiment.clearance import Clearance
from dr_lab.diagnosis.next_experiment.family import Bounds
from dr_lab.diagnosis.next_experiment.limits import Limits
from dr_lab.diagnosis.settings import SolverSettings, WindowSettings
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Noise, Signal


@dataclass(frozen=True)
class Contender:
    """A model that was fitted to the logs, with what the fit does not know.

    Attributes:
        model: the model with its effects.
        z: fitted context, shape (n,).
        covariance: of it, shape (n, n).
    """

    model: Model
    z: Array
    covariance: Array

    @property
    def label(self) -> str:
        """Its last effect, or its name where it has none."""
        return self.model.effects[-1].label if self.model.effects else self.model.name

    def drawn(self, count: int, spread: float, generator: np.random.Generator) -> Array:
        """The fitted context and others within what the fit does not know, shape (1 + count, n)."""
        values, vectors = np.linalg.eigh(self.covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        drawn = self.z + spread * generator.normal(size=(count, len(self.z))) @ root.T
        return np.concatenate([self.z[None], self.model.space.clip(drawn)])


@dataclass(frozen=True)
class ExperimentMachine:
    """What an experiment on the machine can do and show.

    Attributes:
        start: positions at which it begins, at rest, shape (nq,).
        names: the actuators that are commanded, m of them.
        bounds: of their commands.
        kept: what the simulated motion keeps.
        clearance: distances between its parts.
        noise: noise of the measured channels.
        windows: how its log is cut.
        solver: settings of the fits.
        command_rate: commands a second, Hz.
        sample_rate: samples a second of every channel, Hz.
        longest_window: share of an experiment's duration.
        threads: C threads.
    """

    start: Array
    names: Sequence[str]
    bounds: Bounds
    kept: Limits
    clearance: Clearance
    noise: Mapping[str, Noise]
    windows: WindowSettings
    solver: SolverSettings
    command_rate: float
    sample_rate: float
    longest_window: float
    threads: int | None

    def command_times(self, duration: float) -> Array:
        """When commands are sent, s."""
        return np.arange(round(duration * self.command_rate) + 1) / self.command_rate

    def sample_times(self, duration: float) -> Array:
        """When channels are sampled, s."""
        return np.arange(0.0, duration, 1 / self.sample_rate)

    def signals(self, values: Array, time: Array) -> list[dict[str, Signal]]:
        """Commands of n experiments by actuator, shape (n, m, k)."""
        return [{a: Signal(a, "", time, row) for a, row in zip(self.names, rows, strict=True)} for rows in values]

    def cutting(self, duration: float) -> WindowSettings:
        """How a log of this length is cut: in no longer windows than the logs are."""
        return self.windows.of_length(min(self.windows.length, self.longest_window * duration))

    def seconds(self, duration: float, most: float, count: int) -> WindowSettings:
        """The same for so many logs, of each of which only some seconds are simulated."""
        return replace(self.cutting(duration), seconds=count * min(most, duration))
