"""An operator that moves the set points of position controllers."""

from dataclasses import dataclass

import numpy as np

from dr_lab.plants.command import Command
from dr_lab.plants.motion import simulate
from dr_lab.plants.operator import Experiment
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Targets:
    """The wish is a joint's way from its start; the command is the place. Actuator i controls joint i.

    Before the first command each controller holds its joint where it starts.
    """

    def operate(self, experiment: Experiment, wish: Array) -> tuple[Array, Array]:
        """Send where the joints should be."""
        start = np.asarray(experiment.start[: wish.shape[1]])
        asked, acts = wish + start, experiment.issued + experiment.latency
        states = simulate(
            experiment.machine,
            experiment.effect,
            [Command(acts, column, before) for column, before in zip(asked.T, start.tolist(), strict=True)],
            experiment.instants,
            accuracy=experiment.accuracy,
            start=experiment.start,
        )
        return states, asked
