"""A two-legged machine runs forwards in the plane."""

from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.bounds import Finite, NotNegative
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class HalfCheetah(Task):
    """HalfCheetah-v5 of gymnasium: r = w_x v_x − w_u |u|²; it never ends but by the time limit.

    Source: gymnasium 1.4, envs/mujoco/half_cheetah_v5.py (MIT licence).

    Attributes:
        forward_weight: w_x, reward per m/s.
        control_weight: w_u, cost per squared control.
        start_noise: half width of the uniform noise on positions, and standard deviation of the velocities, at the
            start.
    """

    forward_weight: Finite
    control_weight: Finite
    start_noise: NotNegative

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest, with noise."""
        noise = self.start_noise
        return compiled.qpos0 + rng.uniform(-noise, noise, compiled.nq), noise * rng.standard_normal(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Positions but the first, then velocities."""
        del values
        return np.concatenate([fields["qpos"][:, 1:], fields["qvel"]], axis=1)

    def marker(self, fields: Fields) -> Array:
        """The horizontal position."""
        return fields["qpos"][:, :1]

    def reward(self, change: Change) -> Array:
        """Forward, effort."""
        return self.forward_weight * change.velocity[:, 0] - self.control_weight * np.square(change.action).sum(1)
