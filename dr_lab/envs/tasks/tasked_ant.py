"""A four-legged machine that is asked for something else in every episode, as meta-learning has it."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.bounds import Finite
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.envs.tasks.ant_body import TORSO, AntInContact
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class TaskedAnt(AntInContact):
    """r = (what is asked for) + r_s − w_u |u|² − w_c |f|²; it ends off the height range.

    What is asked for is part of the context and is not seen. Differences from Ant-v5 of gymnasium: r_s is also that of
    the step in which it falls; x and y, the torso's rotation matrix and its place are seen, too.

    Source: Finn et al. 2017 (cbfinn/maml_rl, commit 9c8e2eb) and pytorch-maml-rl, commit 21d4ba1, envs/mujoco/ant.py.

    Attributes: as `AntInContact`, and
        survive_reward: r_s, of every step.
    """

    survive_reward: Finite
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "xpos", "xmat", "cfrc_ext")

    def observe(self, fields: Fields, values: Values) -> Array:
        """Positions, velocities, contact forces, the torso's rotation matrix and place, shape (n, 119).

        The sources have 6 columns more, the world's contact forces, which are 0.
        """
        del values
        pose = [fields[name][:, TORSO].reshape(len(fields[name]), -1) for name in ("xmat", "xpos")]
        return np.concatenate([fields["qpos"], fields["qvel"], self.forces(fields), *pose], axis=1)

    @abstractmethod
    def asked(self, change: Change) -> Array:
        """How well a step does what is asked for, shape (n,)."""

    def reward(self, change: Change) -> Array:
        """What is asked for, surviving, effort, contacts."""
        return self.asked(change) + self.survive_reward - self.effort(change) - self.contacts(change)
