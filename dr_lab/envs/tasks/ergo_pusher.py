"""Three servos on vertical axes push a puck to a goal."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import ne
from typing import Annotated

import mujoco
import numpy as np

from dr_lab.bounds import FINITE, NotNegative, Positive, numbers, places
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array

_ARM, _PUCK, _GOAL = [0, 1, 2], [4, 3], [5, 6]  # columns of the positions; the puck's y comes before its x


@dataclass(frozen=True, kw_only=True)
class ErgoPusher(Task):
    """ErgoPusher-v0: r = −|puck − goal|, and 1 where this is less than `reached`; places after the step.

    An episode lasts to the time limit; in the source, reaching ends it. Actions are the servos' angles. The goal is two
    joints of the model that nothing drives, so that it is part of an episode's start.

    Source: gym-ergojr, envs/ergo_pusher_env.py.

    Attributes:
        reached: m.
        rest: angles about which episodes start, rad, shape (3,).
        start_angle: half width of the uniform start about these, rad; cut off at the joints' limits.
        angle: what is seen as 1, rad.
        speed: what is seen as 1, rad/s.
        puck_range: x, y of the puck at the start that are seen as 0, and those seen as 1, m, shape (2, 2).
        goal_range: likewise of the goal.
    """

    reached: NotNegative
    rest: Annotated[Sequence[float], numbers(3, FINITE)]
    start_angle: NotNegative
    angle: Positive
    speed: Positive
    puck_range: Annotated[Sequence[Sequence[float]], places(ne, "which differ in both")]
    goal_range: Annotated[Sequence[Sequence[float]], places(ne, "which differ in both")]

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest, the arm near its resting place, puck and goal in their ranges."""
        qpos, reach = np.zeros(compiled.nq), compiled.jnt_range[_ARM]
        angles = self.rest + rng.uniform(-self.start_angle, self.start_angle, len(_ARM))
        qpos[_ARM] = np.clip(angles, reach[:, 0], reach[:, 1])
        qpos[_PUCK + _GOAL] = rng.uniform(*np.sort(np.hstack([self.puck_range, self.goal_range]), axis=0))
        return qpos, np.zeros(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Angles, velocities, puck and goal, shape (n, 10)."""
        del values
        qpos = fields["qpos"]
        places = [_share(qpos[:, _PUCK], self.puck_range), _share(qpos[:, _GOAL], self.goal_range)]
        return np.concatenate([qpos[:, _ARM] / self.angle, fields["qvel"][:, _ARM] / self.speed, *places], axis=1)

    def reward(self, change: Change) -> Array:
        """Of the distance on the table."""
        qpos = change.fields["qpos"]
        distance = np.linalg.norm(qpos[:, _PUCK] - qpos[:, _GOAL], axis=1)
        return np.where(distance < self.reached, 1.0, -distance)


def _share(place: Array, ends: Sequence[Sequence[float]]) -> Array:
    """Way from the first place to the second, 0 to 1 in between, shape (n, 2)."""
    first, second = np.array(ends)
    return (place - first) / (second - first)
