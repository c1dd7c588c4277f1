"""What all tasks of the four-legged machine have in common: how it begins, when it falls, what costs."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import ORDERED, Finite, Limit, NotNegative
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array

TORSO = 1
"""The first body of the machine."""


@dataclass(frozen=True, kw_only=True)
class AntBody(Task):
    """It starts near rest and ends off the height range; control costs w_u |u|².

    Attributes:
        control_weight: w_u, cost per squared control.
        height_range: of the torso's z in m, both ends included.
        start_noise: half width of the uniform noise on positions, and standard deviation of the velocities, at the
            start.
    """

    control_weight: Finite
    height_range: Annotated[Sequence[float], ORDERED]
    start_noise: NotNegative
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "xpos")

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest, with noise."""
        noise = self.start_noise
        return compiled.qpos0 + rng.uniform(-noise, noise, compiled.nq), noise * rng.standard_normal(compiled.nv)

    def marker(self, fields: Fields) -> Array:
        """The torso's x as MuJoCo's step leaves it: that of the integrator's last evaluation."""
        return fields["xpos"][:, TORSO, :1]

    def effort(self, change: Change) -> Array:
        """What control costs, shape (n,)."""
        return self.control_weight * np.square(change.action).sum(1)

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        """Where the torso is too low or too high."""
        del values
        low, high = self.height_range
        height = fields["qpos"][:, 2]
        return ~((low <= height) & (height <= high))


@dataclass(frozen=True, kw_only=True)
class AntInContact(AntBody):
    """Contact forces f are known, within bounds, and cost w_c |f|².

    Attributes:
        contact_weight: w_c, cost per squared contact force or torque.
        contact_limit: of each of them, in N and N·m.
    """

    contact_weight: Finite
    contact_limit: Limit
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "xpos", "cfrc_ext")

    def forces(self, fields: Fields) -> Array:
        """Contact forces within their bounds on every body but the world, shape (n, 6 bodies)."""
        forces = fields["cfrc_ext"][:, TORSO:]
        return np.clip(forces, -self.contact_limit, self.contact_limit).reshape(len(forces), -1)

    def contacts(self, change: Change) -> Array:
        """What contacts cost, shape (n,)."""
        return self.contact_weight * np.square(self.forces(change.fields)).sum(1)
