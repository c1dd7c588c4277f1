"""A four-legged machine walks forwards."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array

_TORSO = 1  # the first body of the machine


@dataclass(frozen=True, kw_only=True)
class AntWithoutContacts(Task):
    """Ant-v5 of gymnasium without contact forces: r = w_x v_x + r_h − w_u |u|²; it ends off the height range.

    That is gymnasium's task with ``include_cfrc_ext_in_observation=False, contact_cost_weight=0``.

    Source: gymnasium 1.4, envs/mujoco/ant_v5.py (MIT licence).

    Attributes:
        forward_weight: w_x, reward per m/s of the torso.
        healthy_reward: r_h, of every step that does not leave the range.
        control_weight: w_u, cost per squared control.
        height_range: of the torso's z in m, both ends included.
        start_noise: half width of the uniform noise on positions, and standard deviation of the velocities, at the
            start.
    """

    forward_weight: float
    healthy_reward: float
    control_weight: float
    height_range: Sequence[float]
    start_noise: float
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "xpos")

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest, with noise."""
        noise = self.start_noise
        return compiled.qpos0 + rng.uniform(-noise, noise, compiled.nq), noise * rng.standard_normal(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Positions but x and y, then velocities."""
        del values
        return np.concatenate([fields["qpos"][:, 2:], fields["qvel"]], axis=1)

    def marker(self, fields: Fields) -> Array:
        """The torso's x as MuJoCo's step leaves it: that of the integrator's last evaluation."""
        return fields["xpos"][:, _TORSO, :1].copy()

    def reward(self, change: Change) -> Array:
        """Forward, alive, effort."""
        alive = self.healthy_reward * ~change.terminated
        effort = self.control_weight * np.square(change.action).sum(1)
        return self.forward_weight * change.velocity[:, 0] + alive - effort

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        """Where the torso is too low or too high."""
        del values
        low, high = self.height_range
        height = fields["qpos"][:, 2]
        return ~((low <= height) & (height <= high))


@dataclass(frozen=True, kw_only=True)
class Ant(AntWithoutContacts):
    """Ant-v5 of gymnasium: the same, with contact forces seen, within bounds, and w_c |f|² taken off the reward.

    Attributes:
        contact_weight: w_c, cost per squared contact force or torque.
        contact_limit: of each of them, in N and N·m.
    """

    contact_weight: float
    contact_limit: float
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "xpos", "cfrc_ext")

    def observe(self, fields: Fields, values: Values) -> Array:
        """The same, then contact forces on every body."""
        forces = self._forces(fields)[:, _TORSO:]
        return np.concatenate([super().observe(fields, values), forces.reshape(len(forces), -1)], axis=1)

    def reward(self, change: Change) -> Array:
        """The same less the contacts."""
        return super().reward(change) - self.contact_weight * np.square(self._forces(change.fields)).sum((1, 2))

    def _forces(self, fields: Fields) -> Array:
        return np.clip(fields["cfrc_ext"], -self.contact_limit, self.contact_limit)
