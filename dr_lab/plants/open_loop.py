"""An operator that plays prepared commands."""

from dataclasses import dataclass

from dr_lab.plants.command import Command
from dr_lab.plants.motion import simulate
from dr_lab.plants.operator import Experiment
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class OpenLoop:
    """The wish is the command."""

    def operate(self, experiment: Experiment, wish: Array) -> tuple[Array, Array]:
        """Send what is wished."""
        acts = experiment.issued + experiment.latency
        states = simulate(
            experiment.machine,
            experiment.effect,
            [Command(acts, column) for column in wish.T],
            experiment.instants,
            accuracy=experiment.accuracy,
            start=experiment.start,
        )
        return states, wish
