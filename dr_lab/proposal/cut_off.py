"""Commands beyond what the model lets through: the range of a control, or of what actuators do at a joint."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from dr_lab.measurements.units import unit as unit_of
from dr_lab.proposal.drives import Command

_BEYOND = 1e-3  # share of a range by which rounding goes beyond its ends
_JOINT = int(mujoco.mjtTrn.mjTRN_JOINT)


def cut_off(model: mujoco.MjModel, commands: Sequence[Command]) -> Iterator[str]:
    """What is unsure about commands that the model cuts off, a sentence each.

    Where the machine does not, a scale of its forces would be named for it.

    Args:
        model: compiled, with the actuators that were added.
        commands: as they are read.
    """
    for command in commands:
        drive = command.drive
        raw = np.concatenate([[signal.value.min(), signal.value.max()] for signal in command.series.signals])
        value = (command.sign * command.scale * raw + command.offset) * unit_of(command.unit).factor
        actuator, joint = model.actuator(drive.name), int(model.dof_jntid[drive.dof])
        unit = "" if drive.unit == "1" else f" {drive.unit}"
        limits = [("ctrlrange", bool(actuator.ctrllimited[0]), actuator.ctrlrange, value, unit)]
        if not drive.servo and not drive.rate and int(actuator.trntype[0]) == _JOINT:
            newton = " N" if drive.slides else " N·m"
            limited = bool(model.jnt_actfrclimited[joint])
            limits += [("actuatorfrcrange", limited, model.jnt_actfrcrange[joint], drive.force * value, newton)]
        for name, limited, (low, high), asked, measure in limits:
            margin = _BEYOND * (high - low)
            if limited and (asked.min() < low - margin or asked.max() > high + margin):
                yield (
                    f"{drive.name}: its command asks for {asked.min():.3g} … {asked.max():.3g}{measure}, of which the "
                    f"model's {name} lets {low:.3g} … {high:.3g} through. If the machine does more, widen that."
                )
