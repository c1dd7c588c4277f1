"""Where a free body begins a window, from sensors of its frame."""

from collections.abc import Collection
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.windows.channels import Channel, available
from dr_lab.trajectory import Array

_FRAME = int(mujoco.mjtObj.mjOBJ_XBODY)


@dataclass(frozen=True)
class FreeBody:
    """A body on a free joint of the world whose frame sensors see.

    Attributes:
        address: first of its seven entries in qpos.
        dof: first of its six degrees of freedom.
        position: channel of its frame's position in the world, if there is one.
        orientation: channel of its frame's orientation in the world, if there is one.
    """

    address: int
    dof: int
    position: Channel | None
    orientation: Channel | None


def free_bodies(model: mujoco.MjModel, measured: Collection[str]) -> tuple[FreeBody, ...]:
    """Free bodies that measured channels show directly: ``framepos`` and ``framequat`` of the ``xbody``, in the world.

    Args:
        model: compiled model.
        measured: names of the measured channels.
    """
    channels = available(model)
    seen = {
        (int(model.sensor_objid[i]), int(model.sensor_type[i])): channels[f"sensor.{model.sensor(i).name}"]
        for i in range(model.nsensor)
        if int(model.sensor_objtype[i]) == _FRAME and model.sensor_refid[i] < 0
        if f"sensor.{model.sensor(i).name}" in measured
    }
    found = []
    for i in np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE):
        body = int(model.jnt_bodyid[i])
        sensors = (int(mujoco.mjtSensor.mjSENS_FRAMEPOS), int(mujoco.mjtSensor.mjSENS_FRAMEQUAT))
        position, orientation = (seen.get((body, sensor)) for sensor in sensors)
        if position or orientation:
            found.append(FreeBody(int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i]), position, orientation))
    return tuple(found)


def turning(quaternion: Array, slope: Array, curvature: Array) -> tuple[Array, Array, Array]:
    """Orientation, angular velocity and angular acceleration in the body's frame, as a free joint has them.

    ω = 2 (q* ⊗ q')_vec and ω' = 2 (q* ⊗ q'')_vec of a unit quaternion.

    Args:
        quaternion: wxyz, near unit length, shape (w, 4).
        slope: its time derivative, shape (w, 4).
        curvature: its second time derivative, shape (w, 4).

    Returns:
        Unit quaternions (w, 4), rad/s (w, 3), rad/s² (w, 3).
    """
    length = np.linalg.norm(quaternion, axis=1, keepdims=True)
    unit = quaternion / length
    velocity, acceleration = (2.0 * _conjugate_product(unit, rate / length) for rate in (slope, curvature))
    return unit, velocity, acceleration


def continuous(quaternion: Array) -> Array:
    """The same orientations (n, 4) with signs such that neighbours lie on one side, as a polynomial needs them."""
    flips = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0
    sign = np.cumprod(np.concatenate([[1.0], np.where(flips, -1.0, 1.0)]))
    return quaternion * sign[:, None]


def turn_between(first: Array, second: Array) -> Array:
    """Rotation vectors from one set of orientations wxyz to another, in the first one's frame, shape (w, 3)."""
    one, other = (Rotation.from_quat(q, scalar_first=True) for q in (first, second))
    return (one.inv() * other).as_rotvec()


def _conjugate_product(unit: Array, rate: Array) -> Array:
    """Vector part of q* ⊗ r, shape (w, 3)."""
    w, v = unit[:, :1], unit[:, 1:]
    return w * rate[:, 1:] - rate[:, :1] * v - np.cross(v, rate[:, 1:])
