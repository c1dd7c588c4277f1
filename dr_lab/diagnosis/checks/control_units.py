"""Commands in a unit that their actuator cannot have: a torque for a slide, or a force for a hinge."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from dr_lab.diagnosis.windows.commands import actuator_columns
from dr_lab.errors import DataError
from dr_lab.trajectory import Log

_AT_JOINT = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
_KINDS = {  # by the joint's type: what it is, the unit of its force, what that is, and the ratio that makes it
    int(mujoco.mjtJoint.mjJNT_SLIDE): ("slide", "N", "a force", "a drum or a screw makes a force of the torque", "1/m"),
    int(mujoco.mjtJoint.mjJNT_HINGE): ("hinge", "N·m", "a torque", "a lever makes a torque of the force", "m"),
}


def require_control_units(model: mujoco.MjModel, logs: Sequence[Log]) -> None:
    """Refuse a command in N·m whose actuator pushes a slide, and one in N whose actuator turns a hinge.

    That is certain where the joint's force is the control itself: a motor on a joint whose gear is 1 or −1. Behind
    another gear or gain, on a tendon or at a site either may be right.

    Args:
        model: compiled.
        logs: the logs.

    Raises:
        DataError: a unit is the other one; the message names actuator, joint and both remedies.
        UnknownNameError: a command has no actuator.
    """
    actuator_columns(model, logs)
    for log in logs:
        for name, signal in log.commands.items():
            for joint, (kind, unit, force, transmission, ratio) in _pushed(model, name):
                if signal.unit in {"N", "N·m"} - {unit}:
                    raise DataError(
                        f"Command {name} is declared in {signal.unit}, but it is the force of joint {joint}, a {kind}: "
                        f"expected {force}, such as {unit}. Correct the unit of measurements.commands.{name}; where "
                        f"{transmission}, write its ratio ({ratio}) as gear of actuator {name} in the MJCF."
                    )


def _pushed(model: mujoco.MjModel, name: str) -> Iterator[tuple[str, tuple[str, str, str, str, str]]]:
    """The joint whose force is an actuator's control, and what is known of its kind; none where it is not."""
    k = model.actuator(name).id
    alone = int(model.actuator_biastype[k]) == int(mujoco.mjtBias.mjBIAS_NONE)
    fixed = int(model.actuator_gaintype[k]) == int(mujoco.mjtGain.mjGAIN_FIXED) and model.actuator_gainprm[k, 0] == 1.0
    straight = np.abs(model.actuator_gear[k, 0]) == 1.0 and int(model.actuator_trntype[k]) in _AT_JOINT
    if alone and fixed and straight:
        joint = int(model.actuator_trnid[k, 0])
        if (kind := int(model.jnt_type[joint])) in _KINDS:
            yield model.joint(joint).name, _KINDS[kind]
