"""A machine under a controller, which asks for commands as the machine moves."""

import itertools
from collections.abc import Callable

import numpy as np

from dr_lab.plants.body import Body
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine, Vector
from dr_lab.plants.motion import Accuracy, Run
from dr_lab.plants.phases import State
from dr_lab.trajectory import Array

Controller = Callable[[int, Vector, Vector], Vector]  # commands at the i-th instant, seeing positions and velocities


def track(
    machine: Machine,
    effect: HiddenEffect,
    controller: Controller,
    issued: Array,
    latency: float,
    time: Array,
    *,
    accuracy: Accuracy,
    start: State | None = None,
) -> tuple[Array, Array]:
    """True motion of the machine with its hidden effect, and the commands that the controller gave.

    The controller sees the joints as they are: the drives have their own resolvers.

    Args:
        machine: the machine without the effect.
        effect: what is hidden in it.
        controller: what is sent to each actuator at an instant.
        issued: those instants, s, increasing, shape (k,).
        latency: s from then until a command acts.
        time: when to report the state, s, not decreasing.
        accuracy: how closely to follow it.
        start: positions, then velocities, at time 0; None means zero.

    Returns:
        States at each time as by `motion.simulate`, and commands, shape (k, m).

    Raises:
        DataError: `time` is empty or decreases, or the integration fails.
    """
    run = Run(Body.of(machine, effect), accuracy, time, start)
    actuators, joints, degrees = machine.actuators, len(machine.joints), len(run.state) // 2
    acts = [effect.command(name, Command(issued + latency, np.zeros(len(issued)))).edge for name in actuators]
    asked, acting = np.zeros((len(issued), len(actuators))), np.zeros((len(issued) + 1, len(actuators)))
    edges = np.concatenate([[0.0, run.end], issued, *acts])
    bounds = np.unique(edges[(edges >= 0) & (edges <= run.end)])
    known = 0
    for begin, stop in itertools.pairwise(bounds):
        if known < len(issued) and issued[known] <= begin:
            asked[known] = controller(known, run.state[:joints], run.state[degrees : degrees + joints])
            for column, name in enumerate(actuators):
                sample = Command(issued[known : known + 1], asked[known, column : column + 1])
                acting[known + 1, column] = effect.command(name, sample).value[0]
            known += 1
        rows = [int(np.searchsorted(edge, begin, side="right")) for edge in acts]
        run.advance(float(begin), float(stop), acting[rows, range(len(actuators))].tolist())
    return run.states, asked
