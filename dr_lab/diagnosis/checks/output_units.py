"""Measured joints in a unit that they cannot have: a length of a hinge, or an angle of a slide."""

from collections.abc import Sequence

import mujoco

from dr_lab.errors import DataError
from dr_lab.trajectory import Log

# By the joint's type: what it is, the units of its position and velocity, what these are, and how the other is read.
_UNITS = {
    int(mujoco.mjtJoint.mjJNT_SLIDE): ("slide", ("m", "m/s"), "a length", "its way over each radian"),
    int(mujoco.mjtJoint.mjJNT_HINGE): ("hinge", ("rad", "rad/s"), "an angle", "its angle over each metre"),
}
_KINDS = ("position", "velocity")
_KNOWN = {unit for _, units, *_ in _UNITS.values() for unit in units}


def require_output_units(model: mujoco.MjModel, logs: Sequence[Log]) -> None:
    """Refuse the position or velocity of a hinge in metres, and that of a slide in radians.

    Args:
        model: compiled.
        logs: the logs; a unit that is neither, or none, is not judged.

    Raises:
        DataError: a unit is the other one; the message names channel, joint and both remedies.
    """
    for i in (k for k in range(model.njnt) if int(model.jnt_type[k]) in _UNITS):
        kind, units, quantity, ratio = _UNITS[int(model.jnt_type[i])]
        joint = model.joint(i).name
        for channel, expected in zip((f"{joint}.{each}" for each in _KINDS), units, strict=True):
            for signal in (log.outputs[channel] for log in logs if channel in log.outputs):
                if signal.unit in _KNOWN - {expected}:
                    raise DataError(
                        f"Channel {channel} is declared in {signal.unit}, but joint {joint} is a {kind}: expected "
                        f"{quantity}, such as {expected}. Correct the unit of measurements.outputs.{channel}; where "
                        f"the sensor does measure the other, write {expected} and as scale {ratio}."
                    )
