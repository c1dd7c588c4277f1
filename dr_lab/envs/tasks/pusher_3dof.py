"""A planar arm of three links pushes a puck to a goal."""

from collections.abc import Sequence
from dataclasses import dataclass
from operator import le
from typing import Annotated, ClassVar

import mujoco
import numpy as np

from dr_lab.bounds import Finite, NotNegative, Positive, places
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.errors import ConfigError
from dr_lab.trajectory import Array

_ARM, _PUCK, _GOAL = slice(0, 3), slice(3, 5), slice(5, 7)  # columns of the positions


@dataclass(frozen=True, kw_only=True)
class Pusher3Dof(Task):
    """Pusher-3DOF-v0: r = −|puck − goal| − w |a|², with the places *before* the step and the action a in it.

    An episode lasts to the time limit. The goal is two joints of the model that nothing drives, so that it is part of
    an episode's start.

    Source: active-domainrand, common/envs/pusher3dof.py (Mehta et al. 2020).

    Attributes:
        effort: largest torque, N·m.
        action_weight: w, cost per squared torque.
        start_noise: half width of the uniform noise on the arm's angles at the start, rad.
        puck_range: least and largest x, y of the puck at the start, m, shape (2, 2).
        goal_range: likewise of the goal.
        apart: least distance of these two, m; both are drawn again where they are closer.

    Raises:
        ConfigError: a number is out of its range, or no puck and goal within their ranges are so far apart.
    """

    effort: Positive
    action_weight: Finite
    start_noise: NotNegative
    puck_range: Annotated[Sequence[Sequence[float]], places(le, "least and largest")]
    goal_range: Annotated[Sequence[Sequence[float]], places(le, "least and largest")]
    apart: NotNegative
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "site_xpos")

    def __post_init__(self) -> None:
        super().__post_init__()
        puck, goal = np.array(self.puck_range), np.array(self.goal_range)
        widest = float(np.linalg.norm(np.maximum(puck[1] - goal[0], goal[1] - puck[0])))
        if not self.apart < widest:
            raise ConfigError(
                f"env.task.apart is {self.apart:g} m; expected less than {widest:g} m, the largest distance within "
                "puck_range and goal_range."
            )

    def action_bounds(self, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """±effort."""
        high = np.full(compiled.nu, self.effort)
        return -high, high

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest, the arm near its initial position, puck and goal apart."""
        qpos = compiled.qpos0.copy()
        qpos[_ARM] += rng.uniform(-self.start_noise, self.start_noise, 3)
        (low, high), puck, goal = np.hstack([self.puck_range, self.goal_range]), np.zeros(2), np.zeros(2)
        while np.linalg.norm(puck - goal) <= self.apart:
            puck, goal = np.split(rng.uniform(low, high), 2)
        qpos[_PUCK], qpos[_GOAL] = puck, goal
        return qpos, np.zeros(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """The arm's angles and velocities, then x, y of its wrist's end, the puck and the goal, shape (n, 12)."""
        del values
        qpos, tip = fields["qpos"], fields["site_xpos"][:, 0, :2]
        return np.concatenate([qpos[:, _ARM], fields["qvel"][:, _ARM], tip, qpos[:, _PUCK], qpos[:, _GOAL]], axis=1)

    def marker(self, fields: Fields) -> Array:
        """Distance of the puck from the goal, m."""
        qpos = fields["qpos"]
        return np.linalg.norm(qpos[:, _PUCK] - qpos[:, _GOAL], axis=1, keepdims=True)

    def reward(self, change: Change) -> Array:
        """Distance before the step, effort in it."""
        return -change.before[:, 0] - self.action_weight * np.square(change.action).sum(1)
