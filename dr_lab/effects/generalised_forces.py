"""Generalised forces of a model in several states: what a change of the model does to its joints."""

from collections.abc import Iterator

import mujoco
import numpy as np

from dr_lab.trajectory import Array


def inverse_forces(model: mujoco.MjModel, poses: int) -> Array:
    """Forces that inertia, gravity and Coriolis terms ask of the joints in several states, shape (poses, nv).

    Armature is left out; rotors do not depend on the links.
    """
    forces = np.zeros((poses, model.nv))
    for pose, data in enumerate(_states(model, poses)):
        mujoco.mj_rne(model, data, 1, forces[pose])
    return forces


def fluid_forces(model: mujoco.MjModel, poses: int) -> Array:
    """Forces of the medium on the joints in several states, shape (poses, nv)."""
    forces = np.zeros((poses, model.nv))
    for pose, data in enumerate(_states(model, poses)):
        mujoco.mj_passive(model, data)
        forces[pose] = data.qfrc_fluid
    return forces


def pulls(model: mujoco.MjModel, body: int, poses: int) -> Array:
    """Forces on the joints of 1 N at a body's centre of mass along each axis of the world, shape (poses, 3, nv)."""
    forces = np.zeros((poses, 3, model.nv))
    for pose, data in enumerate(_states(model, poses)):
        mujoco.mj_jacBodyCom(model, data, forces[pose], None, body)
    return forces


def _states(model: mujoco.MjModel, poses: int) -> Iterator[mujoco.MjData]:
    """States in motion, with positions and velocities worked out.

    Every degree of freedom is moved, and moves, by another irrational share of a radian (or metre), so that no symmetry
    of the initial position hides a force.
    """
    data, dofs = mujoco.MjData(model), np.arange(1, model.nv + 1)
    for pose in range(poses):
        data.qpos[:] = model.qpos0
        mujoco.mj_integratePos(model, data.qpos, np.sin(dofs * (1.0 + pose)), 1.0)
        data.qvel[:], data.qacc[:] = np.cos(dofs * (2.0 + pose)), np.sin(dofs * (3.0 + pose) + 1.0)
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        yield data
