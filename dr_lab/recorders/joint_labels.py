"""Names of the columns of a machine's positions, velocities and commands."""

from dataclasses import dataclass

import mujoco
import numpy as np

FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)
_QUATERNION, _RATES = ("qw", "qx", "qy", "qz"), ("wx", "wy", "wz")
LABELS = {FREE: (("x", "y", "z", *_QUATERNION), ("vx", "vy", "vz", *_RATES)), BALL: (_QUATERNION, _RATES)}
"""Columns of a joint's position and velocity as MuJoCo has them, by the joint's type, where these are several."""

_UNITS = {**dict.fromkeys("xyz", "m"), **dict.fromkeys(("vx", "vy", "vz"), "m/s"), **dict.fromkeys(_RATES, "rad/s")}

Column = tuple[str, str]  # name and unit


@dataclass(frozen=True)
class Entry:
    """One number of the positions or velocities of a machine.

    Attributes:
        joint: whose it is; one without a name is called by its number.
        part: which of several numbers of this joint, e.g. ``qw``; empty where it has one.
        unit: of the number.
    """

    joint: str
    part: str
    unit: str

    @property
    def dotted(self) -> str:
        """``arm``, or ``torso.qw``."""
        return f"{self.joint}.{self.part}" if self.part else self.joint


def columns(model: mujoco.MjModel) -> tuple[list[Column], list[Column]]:
    """Name and unit of each column of the positions (nq) and of the velocities (nv), in MuJoCo's order."""
    positions, velocities = entries(model)
    return (
        [(f"{each.joint} {each.part or 'position'}", each.unit) for each in positions],
        [(f"{each.joint} {each.part or 'velocity'}", each.unit) for each in velocities],
    )


def entries(model: mujoco.MjModel) -> tuple[list[Entry], list[Entry]]:
    """What each number of the positions (nq) and of the velocities (nv) is, in MuJoCo's order."""
    positions, velocities = list[Entry](), list[Entry]()
    for row, kind in enumerate(model.jnt_type):
        name = joint_name(model, row)
        if kind in LABELS:
            for found, labels in zip((positions, velocities), LABELS[int(kind)], strict=True):
                found += [Entry(name, label, _UNITS.get(label, "1")) for label in labels]
        else:
            unit = "m" if kind == mujoco.mjtJoint.mjJNT_SLIDE else "rad"
            positions.append(Entry(name, "", unit))
            velocities.append(Entry(name, "", f"{unit}/s"))
    return positions, velocities


def joint_name(model: mujoco.MjModel, row: int) -> str:
    """A joint's name; one without is called by its number."""
    return model.joint(row).name or f"joint_{row}"


def commanded(model: mujoco.MjModel) -> list[int]:
    """Row of the actuator that each control commands, shape (nu,); some actuators take none, and some take two."""
    return np.repeat(np.arange(model.nactuator), model.actuator_ctrlnum).tolist()


def actuators(model: mujoco.MjModel) -> tuple[str, ...]:
    """Name of each control's actuator; one without is called by the joint that it moves, or by its number."""
    return tuple(model.actuator(i).name or _moved(model, i) for i in commanded(model))


def _moved(model: mujoco.MjModel, actuator: int) -> str:
    joints = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    moved = (
        model.joint(model.actuator_trnid[actuator, 0]).name if int(model.actuator_trntype[actuator]) in joints else ""
    )
    return f"actuator of {moved}" if moved else f"actuator_{actuator}"
