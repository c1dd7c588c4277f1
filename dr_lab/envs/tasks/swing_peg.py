"""An arm swings a peg that hangs from its gripper on a soft rope into an inclined hole."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Finite, NotNegative, Positive
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.trajectory import Array

_ARM, _FIRST_SEGMENT = slice(0, 7), slice(7, 9)  # columns of the positions
_PEG_ENDS, _PEG, _HOLE, _GOALS = (
    [0, 2],
    1,
    3,
    [5, 4],
)  # sites: the peg's tail and tip, its middle, the hole, their goals
_SEEN = slice(7, 10)  # columns of the observation: the peg


@dataclass(frozen=True, kw_only=True)
class SwingPeg(Task):
    """Swing-peg-in-hole: r = −w₁ ‖e‖₁ − w₂ ‖e‖₂ − w_a mean(a²), and `solved_bonus` more where the peg is in the hole.

    ‖e‖ is the mean over the peg's two ends of their distance from where they lie when it is in; so it also tells the
    angle. Actions are velocities of the seven joints, ±1 being the machine's action scaling. An episode lasts to the
    time limit.

    Source: Chebotar et al. 2019, §V-A and tables III and IV: distance of peg and hole, alignment, and a bonus for
    solving; joint angles and the peg's position, now and one control step before, are seen. The paper says neither what
    the norms are of nor when the task is solved; that is ours.

    Attributes:
        l1_weight: w₁, per m.
        l2_weight: w₂, per m.
        action_weight: w_a.
        solved_bonus: per control step.
        solved_depth: least depth of the peg's middle in the hole, m; negative above it.
        solved_radius: largest distance of the peg's middle from the hole's axis, m.
        start_angle: half width of the uniform start of the joints' angles, rad, from which their servos pull them back.
        start_swing: half width of the uniform start of the rope's angles at the gripper, rad.
        lag: one control step, s.

    Raises:
        ConfigError: a number is out of its range.
    """

    l1_weight: NotNegative
    l2_weight: NotNegative
    action_weight: NotNegative
    solved_bonus: NotNegative
    solved_depth: Finite
    solved_radius: Positive
    start_angle: NotNegative
    start_swing: NotNegative
    lag: NotNegative
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "site_xpos", "site_xmat", "sensordata")
    measured: ClassVar[Mapping[str, int]] = {"peg.x": 7, "peg.y": 8, "peg.z": 9}

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest near the resting pose, the rope straight and turned at the gripper."""
        qpos = compiled.qpos_spring.copy()
        qpos[_ARM] += rng.uniform(-self.start_angle, self.start_angle, 7)
        qpos[_FIRST_SEGMENT] += rng.uniform(-self.start_swing, self.start_swing, 2)
        return qpos, np.zeros(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """Angles, and x, y, z of the peg's middle in the frame of the hole, whose z points out of it; shape (n, 13).

        The place one control step before is that which the velocity leads back to.
        """
        del values
        sites, frame = fields["site_xpos"], fields["site_xmat"][:, _HOLE].reshape(-1, 3, 3)
        peg = np.einsum("nij,ni->nj", frame, sites[:, _PEG] - sites[:, _HOLE])
        before = peg - self.lag * np.einsum("nij,ni->nj", frame, fields["sensordata"])
        return np.concatenate([fields["qpos"][:, _ARM], peg, before], axis=1)

    def reward(self, change: Change) -> Array:
        """Of distance, action and success."""
        sites = change.fields["site_xpos"]
        away = sites[:, _PEG_ENDS] - sites[:, _GOALS]
        distance = self.l1_weight * np.abs(away).sum(2) + self.l2_weight * np.linalg.norm(away, axis=2)
        solved = self.solved(self.observe(change.fields, change.values))
        return self.solved_bonus * solved - distance.mean(1) - self.action_weight * np.square(change.action).mean(1)

    def solved(self, observation: Array) -> NDArray[np.bool_]:
        """Where the peg's middle is deep enough in the hole."""
        x, y, z = observation[:, _SEEN].T
        return (np.hypot(x, y) <= self.solved_radius) & (z <= -self.solved_depth)
