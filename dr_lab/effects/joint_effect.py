"""What effects at a hinge or slide joint have in common."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.force_range import AT_A_JOINT, leave_force_range_to_drive
from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.naming import joints

SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


class JointEffect(Effect):
    """An effect that sits at one named hinge or slide joint; ball and free joints have no single axis to act on."""

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge and slide joints."""
        return tuple(name for name in joints(model, SCALAR) if name)


def slides(model: mujoco.MjModel, joint: str) -> bool:
    """Whether the joint is a slide, whose position is in m and whose generalised force is in N."""
    return int(model.joint(joint).type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def require_place(model: mujoco.MjModel, joint: str, scales: Scales) -> None:
    """Refuse what acts by the place of a hinge that turns on and on while no channel tells where it is.

    Raises:
        ModelError: so it is; a velocity alone tells how far a joint swings, but not how often it has turned.
    """
    if joint in scales.unmeasured and not slides(model, joint) and scales.position.get(joint, 0.0) > 2 * np.pi:
        raise ModelError("No channel tells where the joint is, and it turns by more than a turn.")


def driven(model: mujoco.MjModel, joint: str) -> bool:
    """Whether an actuator acts on the joint itself."""
    return bool(drives(model, joint).any())


def drives(model: mujoco.MjModel, joint: str) -> NDArray[np.bool_]:
    """Which actuators act on the joint itself, shape (nu,)."""
    at_joints = np.isin(model.actuator_trntype, AT_A_JOINT)
    return at_joints & (model.actuator_trnid[:, 0] == model.joint(joint).id)


def joint_of(spec: mujoco.MjSpec, name: str) -> Any:  # noqa: ANN401 (MjsJoint)
    """The joint of a spec whose passive forces an effect edits.

    Raises:
        UnknownNameError: there is no such joint; the message lists those that exist.
        ModelError: the joint's ``springdamper`` would overwrite the edit when the spec is compiled.
    """
    joint = spec.joint(name)
    if joint is None:
        raise UnknownNameError("joint", name, [j.name for j in spec.joints if j.name], f"model {spec.modelname!r}")
    if all(value > 0 for value in joint.springdamper):
        raise ModelError(
            f"Joint {name!r} has springdamper {joint.springdamper.tolist()}, from which MuJoCo computes stiffness and "
            "damping anew, over what an effect writes. Give the joint stiffness and damping instead."
        )
    return joint


def add_passive_force(spec: mujoco.MjSpec, joint: str, name: str) -> Any:  # noqa: ANN401 (MjsActuator)
    """Add an actuator without any command, whose force on a joint is biasprm · (1, position, velocity).

    MuJoCo knows command-free actuators as a gain type of ``dcmotor`` (``input="none"``); with an affine bias nothing
    of a motor is left, and neither ``ctrl`` nor ``act`` grows. The model's default class for actuators does not apply
    to it. A range of the joint's actuator forces becomes that of its drive (`leave_force_range_to_drive`).
    Source: MuJoCo 4.0, XML reference, actuator/general/biastype, actuator/dcmotor/input and joint/actuatorfrcrange.

    Raises:
        ModelError: several forces share the range of the joint's actuator forces.
    """
    leave_force_range_to_drive(spec, joint)
    actuator = spec.add_actuator()
    actuator.name = name
    actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
    actuator.target = joint
    actuator.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    actuator.ctrlrange = actuator.forcerange = [0.0, 0.0]
    actuator.ctrllimited = actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_FALSE
    actuator.damping, actuator.armature, actuator.nsample, actuator.delay = [0.0, 0.0, 0.0], 0.0, 0, 0.0
    actuator.set_to_dcmotor((0.0, 0.0), 1.0, ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_NONE))
    actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    return actuator
