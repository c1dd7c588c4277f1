"""A two-legged machine with a torso, arms and 17 motors walks forwards."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import ORDERED, Finite, NotNegative, at_least
from dr_lab.envs.task import Change, Fields, Task, Values, within
from dr_lab.trajectory import Array

_FREE = 6  # degrees of freedom of the torso's free joint, which no motor drives
_SEEN = ("cinert", "cvel", "cfrc_ext")  # of every body but the world


@dataclass(frozen=True, kw_only=True)
class Humanoid(Task):
    """Humanoid-v5 of gymnasium: r = w_x v_x + r_h − w_u |u|² − min(w_c |f|², c_max); it ends off the height range.

    v_x is that of the centre of mass. Besides positions and velocities, the policy sees every body's inertia and
    velocity about the centre of mass, the motors' torques and the contact forces.

    Source: gymnasium 1.4, envs/mujoco/humanoid_v5.py (MIT licence).

    Attributes:
        forward_weight: w_x, reward per m/s.
        healthy_reward: r_h, of every step that does not leave the range.
        control_weight: w_u, cost per squared control.
        contact_weight: w_c, cost per squared contact force or torque.
        contact_cost_limit: c_max.
        height_range: of the torso's z in m.
        start_noise: half width of the uniform noise on positions and velocities at the start.
    """

    forward_weight: Finite
    healthy_reward: Finite
    control_weight: Finite
    contact_weight: Finite
    contact_cost_limit: Annotated[float, at_least(0.0)]
    height_range: Annotated[Sequence[float], ORDERED]
    start_noise: NotNegative
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "subtree_com", "qfrc_actuator", *_SEEN)

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest, with noise."""
        noise = self.start_noise
        return compiled.qpos0 + rng.uniform(-noise, noise, compiled.nq), rng.uniform(-noise, noise, compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Positions but x and y, velocities, inertias, bodies' velocities, motors' torques, contact forces."""
        del values
        inertias, velocities, forces = (fields[name][:, 1:].reshape(len(fields[name]), -1) for name in _SEEN)
        state = [fields["qpos"][:, 2:], fields["qvel"]]
        return np.concatenate([*state, inertias, velocities, fields["qfrc_actuator"][:, _FREE:], forces], axis=1)

    def marker(self, fields: Fields) -> Array:
        """The centre of mass's x as MuJoCo's step leaves it: that of the integrator's last evaluation."""
        return fields["subtree_com"][:, 0, :1]

    def reward(self, change: Change) -> Array:
        """Forward, alive, effort, contacts."""
        alive = self.healthy_reward * ~change.terminated
        return self.forward_weight * change.velocity[:, 0] + alive - self.costs(change)

    def costs(self, change: Change) -> Array:
        """What control and contacts cost, shape (n,)."""
        effort = self.control_weight * np.square(change.action).sum(1)
        contacts = self.contact_weight * np.square(change.fields["cfrc_ext"]).sum((1, 2))
        return effort + np.minimum(contacts, self.contact_cost_limit)

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        """Where the torso is too low or too high."""
        del values
        return ~within(fields["qpos"][:, 2], self.height_range)
