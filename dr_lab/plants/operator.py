"""Who sends commands to a machine on its bench."""

from dataclasses import dataclass
from typing import Protocol

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine
from dr_lab.plants.motion import Accuracy
from dr_lab.plants.phases import State
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Experiment:
    """One log before it is made.

    Attributes:
        machine: the machine without the effect.
        effect: what is hidden in it.
        documented: the machine that the operator believes in.
        issued: instants at which commands are sent, s, shape (k,).
        latency: s from then until a command acts.
        instants: when the motion is reported, s, not decreasing, shape (n,).
        start: positions, then velocities, at time 0.
        accuracy: how closely the motion is followed.
    """

    machine: Machine
    effect: HiddenEffect
    documented: Machine
    issued: Array
    latency: float
    instants: Array
    start: State
    accuracy: Accuracy


class Operator(Protocol):
    """What makes commands of a wish."""

    def operate(self, experiment: Experiment, wish: Array) -> tuple[Array, Array]:
        """Run an experiment.

        Args:
            experiment: what is run.
            wish: what is wished of each actuator at each instant, shape (k, m).

        Returns:
            States at the experiment's instants, shape (n, 2 · degrees of freedom), and commands, shape (k, m).
        """
        ...
