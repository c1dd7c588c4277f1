"""A driven joint swings a pole up that hangs from it, or holds it there."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import FINITE, Finite, Limit, Positive, above, at_least, numbers
from dr_lab.envs.rewards import ErrorReward
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array

_POLE = 1  # the second joint; 0 hangs down
_ERRORS, _ACTIONS = 4, 1  # positions and velocities of both joints, and the voltage


@dataclass(frozen=True, kw_only=True)
class SwingUp(Task):
    """The first joint to 0, the pole upright, both at rest; the reward is that of the state after a step.

    Attributes:
        reward_of: of the error from there and of the voltage.
        voltage: largest, in V.
        start_centre: middle of the uniform start, from the model's initial position, in m or rad, shape (2,).
        start_position: its half widths, in m or rad, shape (2,).
        start_velocity: of the velocities about 0, in m/s or rad/s, shape (2,).
        position_limit: beyond which an episode ends, in m or rad, shape (2,).
        velocity_limit: in m/s or rad/s, shape (2,).
        tilt_limit: likewise of the pole's distance from upright, in rad; ``inf`` where it has to swing up first.
        failure_cost: taken off the reward where it ends so.

    Raises:
        ConfigError: a number is out of its range, or the reward is one of another number of errors.
    """

    reward_of: ErrorReward
    voltage: Positive
    start_centre: Annotated[Sequence[float], numbers(2, FINITE)]
    start_position: Annotated[Sequence[float], numbers(2, at_least(0.0), FINITE)]
    start_velocity: Annotated[Sequence[float], numbers(2, at_least(0.0), FINITE)]
    position_limit: Annotated[Sequence[float], numbers(2, above(0.0))]
    velocity_limit: Annotated[Sequence[float], numbers(2, above(0.0))]
    tilt_limit: Limit
    failure_cost: Finite

    def __post_init__(self) -> None:
        super().__post_init__()
        self.reward_of.require_lengths(_ERRORS, _ACTIONS, "env.task.reward_of")

    def action_bounds(self, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """±voltage."""
        high = np.full(compiled.nu, self.voltage)
        return -high, high

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """Uniform about the middle, the velocities about rest."""
        position, velocity = np.array(self.start_position), np.array(self.start_velocity)
        middle = compiled.qpos0 + self.start_centre
        return middle + rng.uniform(-position, position), rng.uniform(-velocity, velocity)

    @abstractmethod
    def observe(self, fields: Fields, values: Values) -> Array:
        """Angles as sine and cosine."""
        del values

    def reward(self, change: Change) -> Array:
        """Of the error and the voltage, less a failure's cost."""
        error = np.concatenate([change.fields["qpos"], change.fields["qvel"]], axis=1)
        error[:, _POLE] = _tilt(change.fields)
        return self.reward_of(error, change.action) - self.failure_cost * change.terminated

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        """Where a position, a velocity or the tilt is beyond its limit."""
        size = np.abs(np.column_stack([fields["qpos"], fields["qvel"], _tilt(fields)]))
        return np.any(size > self.limits(len(size), values), axis=1)

    def limits(self, count: int, values: Values) -> Array:
        """Of positions, velocities and tilt in n simulations, shape (n, 5); alike in all unless said otherwise."""
        del values
        return np.tile([*self.position_limit, *self.velocity_limit, self.tilt_limit], (count, 1))


def _tilt(fields: Fields) -> Array:
    """Angle of the pole from upright within ±π, in rad, shape (n,)."""
    return fields["qpos"][:, _POLE] % (2.0 * np.pi) - np.pi
