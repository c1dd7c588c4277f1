"""From what a sensor reports back to the motion, near a window's start."""

from typing import Protocol

import numpy as np

from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array

_NODES = np.array([-1.0, 0.0, 1.0])
_HALF = 0.01  # s; half the time over which the motion is taken for a parabola
_ROUNDS = 8  # three are exact for a delay of a parabola; a gain of 1 + s leaves s⁹


class Transform(Protocol):
    """Gives what a sensor reports from what it would report of the bare motion."""

    def __call__(self, *, read: Reading) -> Reading:
        """The reading of a motion."""
        ...


def unread(reported: Array, transform: Transform) -> tuple[Array, Array]:
    """What must be added to reported positions and velocities at the windows' start to have those of the motion.

    The motion p whose reading T p is the reported m solves p = p + m − T p, here by fixed-point rounds over parabolas.

    Args:
        reported: position, velocity and acceleration as reported, shape (3, w).
        transform: the sensor.

    Returns:
        Corrections of position and velocity, shape (c or 1, w) each.
    """
    time = (_HALF * _NODES)[None, None]
    goal = _parabola(reported[:, None, :, None])(time)
    motion, read = goal, _parabola(reported[:, None, :, None])
    if (seen := transform(read=read)) is read:
        return np.zeros((1, reported.shape[1])), np.zeros((1, reported.shape[1]))
    for _ in range(_ROUNDS):
        motion = motion + goal - seen(time)
        seen = transform(read=_parabola(_coefficients(motion[..., 0])))
    change = _coefficients(motion[..., 0] - goal[..., 0])
    return change[0][..., 0], change[1][..., 0]


def reach(transform: Transform) -> float:
    """Farthest time in s, into the past or the future, that a reading takes in."""
    seen = [0.0]

    def probe(time: Array) -> Array:
        seen.append(float(np.abs(time).max()))
        return np.zeros((*time.shape, 1))

    transform(read=probe)(np.zeros((1, 1, 1)))
    return max(seen)


def _parabola(coefficients: Array) -> Reading:
    """Position over time of a constant acceleration; coefficients of shape (3, c or 1, w, 1)."""
    position, velocity, acceleration = coefficients
    return lambda time: (position + time * (velocity + 0.5 * time * acceleration))[..., None]


def _coefficients(nodes: Array) -> Array:
    """Position, velocity and acceleration of the parabola through three nodes, (c, w, 3) → (3, c, w, 1)."""
    before, now, after = (nodes[..., k, None] for k in range(3))
    return np.stack([now, (after - before) / (2 * _HALF), (after - 2 * now + before) / _HALF**2])
