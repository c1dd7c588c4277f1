"""A one-legged machine hops forwards."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import ORDERED, Finite, Limit, NotNegative
from dr_lab.envs.task import Change, Fields, Task, Values, within
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class Hopper(Task):
    """Hopper-v5 of gymnasium: r = w_x v_x + r_h − w_u |u|²; the episode ends with a fall.

    A fall is a height or pitch outside of its range, or another position or velocity outside of `state_range`. The
    horizontal position is not seen; velocities are seen within ±`velocity_limit`.

    Source: gymnasium 1.4, envs/mujoco/hopper_v5.py (MIT licence).

    Attributes:
        forward_weight: w_x, reward per m/s.
        healthy_reward: r_h, of every step that does not end in a fall.
        control_weight: w_u, cost per squared control.
        height_range: of the torso's z in m.
        angle_range: of the torso's pitch in rad.
        state_range: of all positions but the horizontal one and all velocities, in their units.
        velocity_limit: in m/s or rad/s.
        start_noise: half width of the uniform noise on positions and velocities at the start.
    """

    forward_weight: Finite
    healthy_reward: Finite
    control_weight: Finite
    height_range: Annotated[Sequence[float], ORDERED]
    angle_range: Annotated[Sequence[float], ORDERED]
    state_range: Annotated[Sequence[float], ORDERED]
    velocity_limit: Limit
    start_noise: NotNegative

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """Upright at rest, with noise."""
        noise = self.start_noise
        return compiled.qpos0 + rng.uniform(-noise, noise, compiled.nq), rng.uniform(-noise, noise, compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Positions but the first, then velocities."""
        del values
        limit = self.velocity_limit
        return np.concatenate([fields["qpos"][:, 1:], np.clip(fields["qvel"], -limit, limit)], axis=1)

    def marker(self, fields: Fields) -> Array:
        """The horizontal position."""
        return fields["qpos"][:, :1]

    def reward(self, change: Change) -> Array:
        """Forward, alive, effort."""
        alive = self.healthy_reward * ~change.terminated
        return (
            self.forward_weight * change.velocity[:, 0] + alive - self.control_weight * np.square(change.action).sum(1)
        )

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        """Where it has fallen."""
        del values
        qpos = fields["qpos"]
        upright = within(qpos[:, 1], self.height_range) & within(qpos[:, 2], self.angle_range)
        small = within(qpos[:, 2:], self.state_range).all(1) & within(fields["qvel"], self.state_range).all(1)
        return ~(upright & small)
