"""A trained policy in a control loop in Python."""

import mujoco
import numpy as np
import torch

from dr_lab.collectors.collector import Policy
from dr_lab.envs.batched_env import single
from dr_lab.envs.setting import Setting
from dr_lab.errors import DataError
from dr_lab.recorders.joint_labels import Column, actuators, columns
from dr_lab.targets.task_view import TaskView
from dr_lab.trajectory import Array


class Controller:
    """A policy that is driven by measured positions and velocities, with what its task makes of them.

    A policy that sees its context is told the nominal one.

    Attributes:
        seconds: length of a control step, s; what `act` returns is to be held for as long.
        positions: name and unit of each position that `act` takes, in their order.
        velocities: the same of the velocities.
        actuators: name of each command that `act` returns, in their order.

    Args:
        setting: machine and task that the policy was trained on.
        policy: without exploration.

    Raises:
        ConfigError: the task reads more than positions and velocities.
    """

    def __init__(self, setting: Setting, policy: Policy) -> None:
        self._view, self._policy = TaskView(setting), policy
        self._model: mujoco.MjModel = setting.model.nominal()
        self.seconds = self._view.seconds
        self.positions, self.velocities = map(tuple, columns(self._model))
        self.actuators = actuators(self._model)

    def act(self, qpos: Array, qvel: Array) -> Array:
        """The command of each actuator, in its unit and within its bounds, shape (nu,).

        Args:
            qpos: positions, shape (nq,), rad or m.
            qvel: velocities, shape (nv,), rad/s or m/s.

        Raises:
            DataError: there are not as many of them as the machine has, or one is not finite.
        """
        state = [
            _known("qpos", qpos, self._model.nq, self.positions),
            _known("qvel", qvel, self._model.nv, self.velocities),
        ]
        observation = single(self._view.observe(*(values[None] for values in state)))
        with torch.no_grad():
            action = self._policy(observation).double().numpy()
        return self._view.commands(action)[0]


def _known(key: str, values: Array, count: int, columns: tuple[Column, ...]) -> Array:
    """One state's positions or velocities, of which there are as many as there should be, all of them numbers."""
    given = np.asarray(values, np.float64)
    if given.shape != (count,) or not np.isfinite(given).all():
        expected = ", ".join(f"{name} in {unit}" for name, unit in columns)
        raise DataError(f"{key} is {given.tolist()}; expected {count} finite numbers: {expected}.")
    return given
