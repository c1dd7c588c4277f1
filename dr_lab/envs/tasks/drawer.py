"""An arm of seven joints opens the drawer of a cabinet with its gripper."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import FINITE, ORDERED, Finite, NotNegative, Positive, above, numbers, require_bounds
from dr_lab.envs.task import Change, Fields, Task, Values
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_JOINTS = tuple(f"joint{i}" for i in range(1, 8))
_ARM, _FINGERS, _DRAWER = slice(0, 7), slice(7, 9), 9  # columns of the positions
_EFFECTOR, _LEFT, _RIGHT, _HANDLE = range(1, 5)  # rows of the sites


@dataclass(frozen=True, kw_only=True)
class DrawerWeights:
    """Weights of the terms of the reward, per control step.

    Attributes:
        distance: w_d, 1/m.
        angle: w_θ, 1/rad.
        opening: w_o, 1/m.
        fingers: w_f.
        action: w_a.

    Raises:
        ConfigError: one of them is not finite.
    """

    distance: Finite
    angle: Finite
    opening: Finite
    fingers: Finite
    action: Finite

    def __post_init__(self) -> None:
        require_bounds(self, "env.task.weights")


@dataclass(frozen=True, kw_only=True)
class Drawer(Task):
    """r = −w_d d − w_θ θ − w_o (wanted − opening)₊ + w_f f − w_a |a|².

    d is the distance of the effector (between the fingertips) from the handle; θ the angle by which the hand is turned
    from where it looks at the drawer with its fingers above and below the bar; f is 1 where the bar is between the
    fingers, else 0. The paper names these terms and their weights; the square of the actions and the way to open that
    is left are a reading of its table. Places are those before the last physics step.

    The policy acts with −1 to 1 on seven joint velocities, each times its scale and its joint's greatest velocity, and
    on the gripper, from closed to open. It sees the joints' angles and the place of the handle.

    Source: Chebotar et al. 2019, IV-A.2 and appendix, table of the drawer.

    Attributes:
        speeds: greatest velocities of the joints, rad/s, shape (7,).
        scale: of every joint, the share of its greatest velocity that action 1 is.
        finger_travel: of each, from closed to open, m.
        pose: of the arm at the start, rad, shape (7,).
        start_noise: half width of the uniform noise on it, rad.
        wanted: how far the drawer is to be opened, m.
        open_at: x of the handle from which on the drawer counts as open, m.
        grasp: half sizes of the region around the handle in which the effector has the bar between its fingers, along
            the bar and along the pull, m.
        weights: of the terms of the reward.
        scales: lowest and highest scale where it varies from joint to joint (``joint1.scale`` … of the context); None
            keeps `scale`.
    """

    speeds: Annotated[Sequence[float], numbers(7, above(0.0), FINITE)]
    scale: Positive
    finger_travel: Positive
    pose: Annotated[Sequence[float], numbers(7, FINITE)]
    start_noise: NotNegative
    wanted: Positive
    open_at: Finite
    grasp: Annotated[Sequence[float], numbers(2, above(0.0), FINITE)]
    weights: DrawerWeights
    scales: Annotated[Sequence[float] | None, ORDERED, numbers(2, above(0.0), FINITE)] = None
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel", "site_xpos", "site_xmat")
    measured: ClassVar[Mapping[str, int]] = {"handle.x": 7, "handle.y": 8, "handle.z": 9}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The scales of the joints, where they vary."""
        if self.scales is None:
            return ()
        low, high = self.scales
        return tuple(Parameter(f"{joint}.scale", "1", self.scale, low, high) for joint in _JOINTS)

    def action_bounds(self, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """±1 for each joint and for the gripper."""
        del compiled
        return -np.ones(8), np.ones(8)

    def controls(self, action: Array, values: Values) -> Array:
        """Velocities of the joints, rad/s, and the distance of the fingers, m, shape (n, 8)."""
        scale = np.stack([values.get(f"{joint}.scale", np.full(len(action), self.scale)) for joint in _JOINTS], axis=1)
        apart = self.finger_travel * (1.0 + action[:, 7:])
        return np.concatenate([scale * self.speeds * action[:, :7], apart], axis=1)

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """At rest near the pose, the gripper open, the drawer closed."""
        qpos = np.zeros(compiled.nq)
        qpos[_ARM] = self.pose + rng.uniform(-self.start_noise, self.start_noise, 7)
        qpos[_FINGERS] = self.finger_travel
        return qpos, np.zeros(compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        """The joints' angles, rad, and the place of the handle, m, shape (n, 10)."""
        del values
        return np.concatenate([fields["qpos"][:, _ARM], fields["site_xpos"][:, _HANDLE]], axis=1)

    def reward(self, change: Change) -> Array:
        """Of the state after the step and the action in it."""
        place, turned, weights = change.fields["site_xpos"], change.fields["site_xmat"][:, _EFFECTOR], self.weights
        away = place[:, _EFFECTOR] - place[:, _HANDLE]
        left = np.maximum(self.wanted - change.fields["qpos"][:, _DRAWER], 0.0)
        return (
            -weights.distance * np.linalg.norm(away, axis=1)
            - weights.angle * _angle(turned.reshape(len(turned), 9))
            - weights.opening * left
            + weights.fingers * self._between(place, away)
            - weights.action * np.square(change.action).sum(axis=1)
        )

    def solved(self, observation: Array) -> NDArray[np.bool_]:
        """Where the handle has come far enough."""
        return observation[:, self.measured["handle.x"]] <= self.open_at

    def _between(self, place: Array, away: Array) -> NDArray[np.bool_]:
        """Where the bar is between the fingers, one above and one below it, shape (n,)."""
        bar = place[:, _HANDLE, 2]
        above, below = place[:, _LEFT, 2] > bar, place[:, _RIGHT, 2] < bar
        return above & below & (np.abs(away[:, [1, 0]]) < self.grasp).all(axis=1)


def _angle(turned: Array) -> Array:
    """Angle of the rotation from (approach along +x, left finger up along +z) to that of the hand, rad, shape (n,)."""
    # The wanted rotation has columns (y, z, x); the trace of the product with a rotation is the sum of these entries.
    trace = turned[:, 3] + turned[:, 7] + turned[:, 2]
    return np.arccos(np.clip(0.5 * (trace - 1.0), -1.0, 1.0))
