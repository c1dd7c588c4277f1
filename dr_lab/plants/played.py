"""An operator that plays commands as a file lists them."""

from dataclasses import dataclass

import numpy as np

from dr_lab.plants.command import Command
from dr_lab.plants.motion import simulate
from dr_lab.plants.operator import Experiment
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Played:
    """Row i of the file is sent from time[i] until time[i + 1]; the last one stays. What is wished counts nothing.

    A command is sent at the instant that is nearest to its time, so that jitter skips no row. Before the first one acts
    the machine is held by the first row.

    Attributes:
        time: s after the start, increasing, shape (r,).
        commands: one column an actuator, in the machine's order and its units, shape (r, m).
    """

    time: Array
    commands: Array

    def operate(self, experiment: Experiment, wish: Array) -> tuple[Array, Array]:
        """Send at each instant the row that is due."""
        del wish
        early = np.ptp(experiment.issued) / max(len(experiment.issued) - 1, 1) / 2
        rows = np.clip(np.searchsorted(self.time, experiment.issued + early, side="right") - 1, 0, None)
        sent, acts = self.commands[rows], experiment.issued + experiment.latency
        states = simulate(
            experiment.machine,
            experiment.effect,
            [Command(acts, column, float(first)) for column, first in zip(sent.T, self.commands[0], strict=True)],
            experiment.instants,
            accuracy=experiment.accuracy,
            start=experiment.start,
        )
        return states, sent
