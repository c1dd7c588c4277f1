"""A base that does not stand level."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, Scales
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_AXES = {"about_x": (1.0, 0.0, 0.0), "about_y": (0.0, 1.0, 0.0)}


@dataclass(frozen=True)
class BaseTilt(Effect, SpecEdit):
    """The base, and with it the world frame, is turned against gravity.

    A base that is turned by the rotation vector r = (r_x, r_y, 0) sees g' = exp(−[r]×) g: for a turn about x,
    g' = g (0, −sin r_x, −cos r_x).

    Parameters (nominal = absent): about_x, about_y [rad]; each only where it changes a generalised force of the model
    to first order (a pendulum that swings about y does not feel a small turn about x).
    Limits: models with gravity; turns about the vertical are left out, gravity does not change under them.
    Source: Rodrigues' rotation formula; MuJoCo option/gravity.

    Attributes:
        largest: bound of either angle [rad].
        sensitive: an angle counts as felt above this share of the force of a gravity in the worst direction.
        poses: number of poses at which that is looked for.
    """

    largest: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "base_tilt"
    family: ClassVar[str] = "environment"
    law: ClassVar[str] = "g -> R(about_x, about_y) g"
    fingerprint: ClassVar[str] = "force residual that depends on where the links point, not on velocity"
    confused_with: ClassVar[tuple[str, ...]] = ("constant_offset", "spring")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """``world``, where gravity acts and a tilt of it is felt."""
        return ("world",) if self._felt(model) else ()

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The angles that are felt."""
        del site, scales
        return tuple(Parameter(axis, "rad", 0.0, -self.largest, self.largest) for axis in self._felt(model))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Turn gravity."""
        del site
        turn, gravity = np.zeros(4), np.zeros(3)
        vector = sum(-values.get(axis, 0.0) * np.array(direction) for axis, direction in _AXES.items())
        angle = float(np.linalg.norm(vector))
        if angle == 0:
            return
        mujoco.mju_axisAngle2Quat(turn, vector / angle, angle)
        mujoco.mju_rotVecQuat(gravity, np.array(spec.option.gravity), turn)
        spec.option.gravity = gravity

    def _felt(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Axes about which a small tilt changes a generalised force at some pose."""
        gravity = np.array(model.opt.gravity, dtype=float)
        strength = float(np.linalg.norm(gravity))
        most = max(_weight(model, strength * direction, self.poses) for direction in np.eye(3))
        return tuple(
            axis
            for axis, direction in _AXES.items()
            if _weight(model, np.cross(gravity, direction), self.poses) > self.sensitive * most
        )


def _weight(model: mujoco.MjModel, gravity: Array, poses: int) -> float:
    """Largest generalised force of a gravity at rest in several poses.

    The poses move every degree of freedom by another irrational share of a radian (or metre), so that no symmetry of
    the initial position hides a force.
    """
    turned = copy(model)
    turned.opt.gravity[:] = gravity
    data, forces = mujoco.MjData(turned), np.zeros((poses, model.nv))
    for pose in range(poses):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(turned, data.qpos, np.sin(np.arange(1, model.nv + 1) * (1.0 + pose)), 1.0)
        mujoco.mj_fwdPosition(turned, data)
        mujoco.mj_rne(turned, data, 0, forces[pose])
    return float(np.abs(forces).max(initial=0.0))
