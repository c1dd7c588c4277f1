"""Unit quaternions wxyz that change with time, and how bodies turn by them."""

import numpy as np
from scipy.spatial.transform import Rotation

from dr_lab.trajectory import Array


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


def of_the_body(quaternion: Array, mount: Array) -> Array:
    """Orientations of a body, or their time derivatives, from those of a frame that is fixed to it.

    Args:
        quaternion: of the frame in the world, q ⊗ m, shape (w, 4).
        mount: unit quaternion m of the frame in the body, shape (4,).

    Returns:
        q = (q ⊗ m) ⊗ m*, shape (w, 4).
    """
    w, v = quaternion[:, :1], quaternion[:, 1:]
    return np.hstack([w * mount[0] + v @ mount[1:, None], v * mount[0] - w * mount[1:] - np.cross(v, mount[1:])])
