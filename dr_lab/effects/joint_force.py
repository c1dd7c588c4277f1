"""Actuators at a hinge or slide, and those whose force is gain times command."""

import mujoco

_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
_FORCE_ALONE = (int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_NONE))


def moves_joint(model: mujoco.MjModel, row: int) -> bool:
    """Whether an actuator, by row, acts on a hinge or slide."""
    at_joint = int(model.actuator_trntype[row]) == int(mujoco.mjtTrn.mjTRN_JOINT)
    return at_joint and int(model.jnt_type[model.actuator_trnid[row, 0]]) in _SCALAR


def drives_joint(model: mujoco.MjModel, row: int) -> bool:
    """Whether an actuator, by row, acts on a hinge or slide with a force that is gain times command."""
    kinds = (int(model.actuator_gaintype[row]), int(model.actuator_biastype[row]))
    direct = int(model.actuator_dyntype[row]) == int(mujoco.mjtDyn.mjDYN_NONE)
    return kinds == _FORCE_ALONE and direct and moves_joint(model, row) and model.actuator_gainprm[row, 0] != 0


def acts_on(model: mujoco.MjModel, actuator: str) -> tuple[str, float, bool]:
    """The joint that an actuator drives, its gear without sign, and whether the joint slides."""
    row = model.actuator(actuator).id
    joint = model.joint(int(model.actuator_trnid[row, 0]))
    slides = int(joint.type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    return joint.name, abs(float(model.actuator_gear[row, 0])), slides
