"""A small arm of four servos reaches for a goal in its plane."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import mujoco
import numpy as np

from dr_lab.bounds import FINITE, ORDERED, NotNegative, Positive, at_least, numbers
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array

_ARM, _GOAL = slice(0, 4), slice(4, 6)  # columns of the positions


@dataclass(frozen=True, kw_only=True)
class ErgoReacher(Task):
    """ErgoReacher-v0, half disc: r = −|tip − goal|, and 1 where this is less than `reached`, after the step.

    The tip is where it was before the last physics step. An episode lasts to the time limit. Actions are the servos'
    angles. The goal is two joints of the model that nothing drives, so that it is part of an episode's start.

    Source: gym-ergojr, envs/ergo_reacher_env.py, whose distance is that in space but for commits of 2019 (x and y
    alone); active-domainrand, common/envs/ergoreacher.py, by which reaching does not end the episode.

    Attributes:
        reached: m.
        start_angle: half width of the uniform start of the angles, rad.
        angle: what is seen as 1, rad.
        speed: what is seen as 1, rad/s.
        goal_centre: y, z of the disc, m.
        goal_radius: least and largest distance of a goal from the centre, m.
        goal_height: largest z of a goal above the centre, m.
        goal_back: largest distance of a goal behind the centre, m, where it lies above half of that height.

    Raises:
        ConfigError: a number is out of its range.
    """

    reached: NotNegative
    start_angle: NotNegative
    angle: Positive
    speed: Positive
    goal_centre: Annotated[Sequence[float], numbers(2, FINITE)]
    goal_radius: Annotated[Sequence[float], ORDERED, numbers(2, at_least(0.0), FINITE)]
    goal_height: Positive
    goal_back: NotNegative
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "site_xpos")

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest near upright, with a goal in the half disc."""
        qpos = np.zeros(compiled.nq)
        qpos[_ARM] = rng.uniform(-self.start_angle, self.start_angle, 4)
        qpos[_GOAL] = self._goal(rng)
        return qpos, np.zeros(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Angles, velocities and goal, each about ±1, shape (n, 10)."""
        del values
        qpos, scale = fields["qpos"], np.array([self.goal_radius[1], 0.5 * self.goal_height])
        goal = (qpos[:, _GOAL] - self.goal_centre) / scale - [0.0, 1.0]
        return np.concatenate([qpos[:, _ARM] / self.angle, fields["qvel"][:, _ARM] / self.speed, goal], axis=1)

    def reward(self, change: Change) -> Array:
        """Of the distance in space; the goal lies in the plane x = 0."""
        tip, goal = change.fields["site_xpos"][:, 0], change.fields["qpos"][:, _GOAL]
        distance = np.hypot(tip[:, 0], np.linalg.norm(tip[:, 1:] - goal, axis=1))
        return np.where(distance < self.reached, 1.0, -distance)

    def _goal(self, rng: np.random.Generator) -> Array:
        """Uniform within the half disc, by rejection."""
        low, high = np.array([-self.goal_back, 0.0]), np.array([self.goal_radius[1], self.goal_height])
        while True:
            place = rng.uniform(low, high)
            behind = place[0] < 0.0 and place[1] <= 0.5 * self.goal_height
            if self.goal_radius[0] <= np.linalg.norm(place) <= self.goal_radius[1] and not behind:
                return self.goal_centre + place
