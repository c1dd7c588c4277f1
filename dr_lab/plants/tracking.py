"""A machine under a controller, which asks for commands as the machine moves."""

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from dr_lab.plants.body import Body
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Vector
from dr_lab.plants.motion import Run
from dr_lab.plants.operator import Experiment
from dr_lab.trajectory import Array

Controller = Callable[[int, Vector, Vector], Vector]  # commands at the i-th instant, seeing positions and velocities


def track(experiment: Experiment, controller: Controller) -> tuple[Array, Array]:
    """True motion of the machine with its hidden effect, and the commands that the controller gave.

    The controller sees the joints as they are: the drives have their own resolvers.

    Args:
        experiment: the machine, what is hidden in it, and when commands are sent and states reported.
        controller: what is sent to each actuator at an instant.

    Returns:
        States at each instant as by `motion.simulate`, and commands, shape (k, m).

    Raises:
        DataError: the instants decrease or there are none, or the integration fails.
    """
    machine, effect, issued = experiment.machine, experiment.effect, experiment.issued
    run = Run(Body.of(machine, effect), experiment.accuracy, experiment.instants, experiment.start)
    actuators, joints, degrees = machine.actuators, len(machine.joints), run.body.degrees
    sent = Command(issued + experiment.latency, np.zeros(len(issued)))
    acts = [effect.command(name, sent).edge for name in actuators]
    asked, acting = np.zeros((len(issued), len(actuators))), np.zeros((len(issued) + 1, len(actuators)))
    edges = np.concatenate([[0.0, run.end], issued, *acts])
    bounds = np.unique(edges[(edges >= 0) & (edges <= run.end)])
    known = 0
    for begin, stop in itertools.pairwise(bounds):
        if known < len(issued) and issued[known] <= begin:
            asked[known] = controller(known, run.state[:joints], run.state[degrees : degrees + joints])
            acting[known + 1] = _acting(effect, actuators, float(issued[known]), asked[known])
            known += 1
        rows = [int(np.searchsorted(edge, begin, side="right")) for edge in acts]
        run.advance(float(begin), float(stop), acting[rows, range(len(actuators))].tolist())
    return run.states, asked


def _acting(effect: HiddenEffect, actuators: Sequence[str], instant: float, asked: Array) -> list[float]:
    """What the hidden effect makes of one command to each actuator."""
    sent = zip(actuators, asked, strict=True)
    return [
        float(effect.command(name, Command(np.array([instant]), np.array([value]))).value[0]) for name, value in sent
    ]
