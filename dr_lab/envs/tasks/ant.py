"""A four-legged machine walks forwards."""

from dataclasses import dataclass

import numpy as np

from dr_lab.bounds import Finite
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.envs.tasks.ant_body import AntBody, AntInContact
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class AntWithoutContacts(AntBody):
    """Ant-v5 of gymnasium without contact forces: r = w_x v_x + r_h − w_u |u|²; it ends off the height range.

    That is gymnasium's task with ``include_cfrc_ext_in_observation=False, contact_cost_weight=0``.

    Source: gymnasium 1.4, envs/mujoco/ant_v5.py (MIT licence).

    Attributes: as `AntBody`, and
        forward_weight: w_x, reward per m/s of the torso.
        healthy_reward: r_h, of every step that does not leave the range.
    """

    forward_weight: Finite
    healthy_reward: Finite

    def observe(self, fields: Fields, values: Values) -> Array:
        """Positions but x and y, then velocities."""
        del values
        return np.concatenate([fields["qpos"][:, 2:], fields["qvel"]], axis=1)

    def reward(self, change: Change) -> Array:
        """Forward, alive, effort."""
        alive = self.healthy_reward * ~change.terminated
        return self.forward_weight * change.velocity[:, 0] + alive - self.effort(change)


@dataclass(frozen=True, kw_only=True)
class Ant(AntWithoutContacts, AntInContact):
    """Ant-v5 of gymnasium: the same, with contact forces seen, within bounds, and w_c |f|² taken off the reward.

    Attributes: as both.
    """

    def observe(self, fields: Fields, values: Values) -> Array:
        """The same, then contact forces on every body."""
        return np.concatenate([super().observe(fields, values), self.forces(fields)], axis=1)

    def reward(self, change: Change) -> Array:
        """The same less the contacts."""
        return super().reward(change) - self.contacts(change)
