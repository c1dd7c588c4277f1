"""Pinocchio, the second engine, and a MuJoCo model's tree of bodies in its terms."""

import functools
import importlib
from types import ModuleType
from typing import Any

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.extras import MissingLibraryError
from dr_lab.plants.inertia import tensor_of
from dr_lab.trajectory import Array


@functools.cache
def pinocchio() -> ModuleType:
    """The library, looked for once: a machine asks for it at every instant.

    Raises:
        MissingLibraryError: it is not installed.
    """
    try:
        return importlib.import_module("pinocchio")
    except ImportError as error:
        raise MissingLibraryError("This machine", "pinocchio") from error


def tree(model: mujoco.MjModel) -> Any:  # noqa: ANN401 (pinocchio.Model)
    """The bodies and joints of a model: masses, centres, inertias, axes and rotor inertias; nothing of its forces.

    A body without a joint is welded to its parent's joint. Pinocchio's joint i + 1 is the model's joint i.

    Args:
        model: compiled, of hinges and slides without a reference position, at most one joint a body.

    Raises:
        ModelError: a body has more than one joint, a joint a reference position, or the model forces that are no
            body's: tendons, equalities, springs, dry frictions, limits.
        MissingLibraryError: Pinocchio is not installed.
    """
    pin = pinocchio()
    if model.qpos0.any() or (model.body_jntnum > 1).any():
        raise ModelError("A machine of Pinocchio has one joint a body at most, each with reference position 0.")
    others = model.ntendon + model.neq + int(model.jnt_limited.sum())
    if others or model.dof_frictionloss.any() or np.any(model.jnt_stiffness):
        raise ModelError("A machine of Pinocchio has no tendons, equalities, joint springs, dry frictions and limits.")
    built = pin.Model()
    holder, frame = {0: 0}, {0: pin.SE3.Identity()}  # of each body: its joint, and its frame in that joint's
    for body in range(1, model.nbody):
        parent = int(model.body_parentid[body])
        placed = frame[parent] * pin.SE3(_rotation(model.body_quat[body]), model.body_pos[body].copy())
        holder[body], frame[body] = holder[parent], placed
        if model.body_jntnum[body]:
            joint = int(model.body_jntadr[body])
            anchor = pin.SE3(np.eye(3), model.jnt_pos[joint].copy())
            kind = _kind(pin, int(model.jnt_type[joint]), model.jnt_axis[joint])
            holder[body] = built.addJoint(holder[parent], kind, placed * anchor, model.joint(joint).name)
            frame[body] = anchor.inverse()
        if holder[body]:
            mass, centre = float(model.body_mass[body]), model.body_ipos[body].copy()
            built.appendBodyToJoint(holder[body], pin.Inertia(mass, centre, tensor_of(model, body)), frame[body])
    built.armature = model.dof_armature.copy()
    built.gravity.linear = model.opt.gravity.copy()
    return built


def _kind(pin: ModuleType, kind: int, axis: Array) -> Any:  # noqa: ANN401 (pinocchio.JointModel)
    if kind == int(mujoco.mjtJoint.mjJNT_HINGE):
        return pin.JointModelRevoluteUnaligned(axis.copy())
    return pin.JointModelPrismaticUnaligned(axis.copy())


def _rotation(quaternion: Array) -> Array:
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, quaternion)
    return turn.reshape(3, 3)
