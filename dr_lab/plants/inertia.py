"""Mass, centre and inertia of a body in a compiled model, changed together."""

import mujoco
import numpy as np

from dr_lab.trajectory import Array


def with_point(model: mujoco.MjModel, row: int, mass: float, place: Array) -> None:
    """Add a point mass to a body, in place: common centre and inertia by the parallel-axis theorem.

    Args:
        model: compiled; its derived constants are to be made anew.
        row: of the body.
        mass: kg.
        place: in the body's frame, m, shape (3,).
    """
    own, centre = float(model.body_mass[row]), model.body_ipos[row].copy()
    common = (own * centre + mass * place) / (own + mass)
    tensor = tensor_of(model, row) + own * _about(centre - common) + mass * _about(place - common)
    model.body_mass[row], model.body_ipos[row] = own + mass, common
    model.body_inertia[row], model.body_iquat[row] = _principal(tensor)
    _own_axes(model, row)


def moved(model: mujoco.MjModel, row: int, offset: Array) -> None:
    """Move a body's centre of mass in its own frame, in place; offset in m, shape (3,)."""
    model.body_ipos[row] += offset
    _own_axes(model, row)


def tensor_of(model: mujoco.MjModel, row: int) -> Array:
    """Inertia of a body about its centre, in the axes of its frame, kg·m², shape (3, 3)."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[row])
    frame = turn.reshape(3, 3)
    return frame @ np.diag(model.body_inertia[row]) @ frame.T


def _own_axes(model: mujoco.MjModel, row: int) -> None:
    """The inertia's frame is no longer the body's, nor is its origin."""
    model.body_sameframe[row] = int(mujoco.mjtSameFrame.mjSAMEFRAME_NONE)


def _about(offset: Array) -> Array:
    """Inertia of a unit mass at an offset, shape (3, 3)."""
    return float(offset @ offset) * np.eye(3) - np.outer(offset, offset)


def _principal(tensor: Array) -> tuple[Array, Array]:
    """Principal moments of inertia, and the quaternion of their axes."""
    moments, axes = np.linalg.eigh(tensor)
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, (axes * np.sign(np.linalg.det(axes))).reshape(-1))
    return moments, turn
