"""Ranges of forces and commands in a spec, and the range of a joint's actuator forces, which its drive keeps."""

from typing import Any

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.trajectory import Array

AT_A_JOINT = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))


def acts(spec: mujoco.MjSpec, choice: int, ends: Array) -> bool:
    """Whether MuJoCo heeds a range of a spec.

    Args:
        spec: the spec.
        choice: what the element says of that, MuJoCo's ``mjtLimited``.
        ends: of the range.
    """
    low, high = ends
    automatic = choice == mujoco.mjtLimited.mjLIMITED_AUTO and spec.compiler.autolimits and (low, high) != (0.0, 0.0)
    return choice == mujoco.mjtLimited.mjLIMITED_TRUE or bool(automatic)


def leave_force_range_to_drive(spec: mujoco.MjSpec, name: str) -> None:
    """Turn a joint's ``actuatorfrcrange`` into the ``forcerange`` of its only actuator.

    MuJoCo clips the sum of all actuators' forces at the joint. A passive force that is added as an actuator would be
    clipped with the drive, although it is none of the drive's.

    Args:
        spec: the caller's own.
        name: of the joint.

    Raises:
        ModelError: other forces share the range, or the two ranges of the actuator have nothing in common.
    """
    joint = spec.joint(name)
    if not acts(spec, joint.actfrclimited, joint.actfrcrange):
        return
    low, high = joint.actfrcrange
    drives = [actuator for actuator in spec.actuators if _may_move(actuator, name)]
    single = all(int(actuator.trntype) in AT_A_JOINT for actuator in drives) and len(drives) < 2
    if not single or joint.actgravcomp:
        raise ModelError(
            f"Joint {name!r} has actuatorfrcrange [{low:g}, {high:g}], which bounds the sum of several forces. It "
            "would bound the effect's force, too; expected one actuator at the joint. Give each actuator of the joint "
            "a forcerange in place of the joint's actuatorfrcrange."
        )
    for actuator in drives:
        _narrow(spec, actuator, np.sort(np.array([low, high]) / actuator.gear[0]))
    joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE


def _may_move(actuator: Any, joint: str) -> bool:  # noqa: ANN401 (MjsActuator)
    """Whether an actuator acts on a joint, as far as the spec alone tells."""
    return int(actuator.trntype) not in AT_A_JOINT or (actuator.target == joint and actuator.gear[0] != 0)


def _narrow(spec: mujoco.MjSpec, actuator: Any, ends: Array) -> None:  # noqa: ANN401 (MjsActuator)
    """Bound an actuator's force, within the range that it has."""
    if acts(spec, actuator.forcelimited, actuator.forcerange):
        (low, high), (least, most) = actuator.forcerange, ends
        ends = np.clip(actuator.forcerange, least, most)
        if ends[0] == ends[1]:
            raise ModelError(
                f"Actuator {actuator.name!r} has forcerange [{low:g}, {high:g}], of which its joint allows "
                f"[{least:g}, {most:g}]; expected ranges that overlap. Correct its forcerange or the joint's "
                "actuatorfrcrange."
            )
    actuator.forcerange, actuator.forcelimited = ends, mujoco.mjtLimited.mjLIMITED_TRUE
