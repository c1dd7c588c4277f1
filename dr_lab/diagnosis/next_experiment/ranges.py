"""Ranges of commands: the actuator's, else what the logs show; those of a position controller stay in its joint's."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from dr_lab.diagnosis.next_experiment.limits import Limits, Safety
from dr_lab.trajectory import Array


def command_ranges(
    model: mujoco.MjModel, limits: Limits, sent: Mapping[str, tuple[float, float]], safety: Safety
) -> dict[str, tuple[float, float]]:
    """Lowest and highest command by actuator; one that has no range is left out.

    Args:
        model: compiled model.
        limits: of the machine.
        sent: lowest and highest command of the logs, by actuator.
        safety: how far beyond these an experiment may go where the actuator declares no ctrlrange.
    """
    found = {}
    for name, (lowest, highest) in sent.items():
        actuator = model.actuator(name).id
        column, joint = int(model.actuator_ctrladr[actuator]), controlled(model, actuator)
        if joint is None:
            peak = (1 + safety.margin) * max(abs(lowest), abs(highest))
            low, high = -peak, peak
        else:
            span, gear = safety.margin * (highest - lowest), float(model.actuator_gear[actuator, 0])
            ends = gear * np.array([limits.low[model.jnt_qposadr[joint]], limits.high[model.jnt_qposadr[joint]]])
            low, high = max(lowest - span, ends.min()), min(highest + span, ends.max())
        if model.actuator_ctrllimited[column]:
            declared = [float(end) for end in model.actuator_ctrlrange[column]]
            low, high = (max(low, declared[0]), min(high, declared[1])) if joint is not None else tuple(declared)
        if high > low:
            found[name] = (float(low), float(high))
    return found


def slews(model: mujoco.MjModel, limits: Limits, names: Sequence[str]) -> Array:
    """Fastest change of each command a second: of a position controller's the speed of its joint, else infinite."""
    found = np.full(len(names), np.inf)
    for row, name in enumerate(names):
        actuator = model.actuator(name).id
        joint = controlled(model, actuator)
        if joint is not None:
            found[row] = abs(float(model.actuator_gear[actuator, 0])) * limits.speed[model.jnt_dofadr[joint]]
    return found


def controlled(model: mujoco.MjModel, actuator: int) -> int | None:
    """The hinge or slide joint whose place is an actuator's command; None where it commands something else.

    The force of a position controller is kp (u − l) − kv l̇, l the actuator's length.
    Source: MuJoCo 4.0, XML reference, actuator/position.
    """
    gain, bias = float(model.actuator_gainprm[actuator, 0]), float(model.actuator_biasprm[actuator, 1])
    fixed = int(model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
    affine = int(model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
    held = int(model.actuator_dyntype[actuator]) not in (int(mujoco.mjtDyn.mjDYN_INTEGRATOR),)
    at_joint = int(model.actuator_trntype[actuator]) == int(mujoco.mjtTrn.mjTRN_JOINT)
    if not (fixed and affine and held and at_joint) or gain == 0 or gain != -bias:
        return None
    return int(model.actuator_trnid[actuator, 0])
