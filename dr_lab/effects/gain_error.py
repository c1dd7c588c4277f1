"""A position servo whose proportional gain is another than documented."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect, actuator_of
from dr_lab.effects.effect import Scales
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class GainError(ActuatorEffect, SpecEdit):
    """A controller that pulls more or less towards its target: F = s kp (u − q) − kv q'.

    Parameters (nominal = absent): factor s of kp > 0, 1 = absent. The damping kv and the force limit stay.
    Limits: actuators that are position servos, gain kp and bias −kp in position. Where the joint's own damping is free,
    a factor of the whole force (`torque_scale`) is the same but for a force limit.
    Source: MuJoCo 4.0, XML reference, actuator/position (kp, kv).

    Attributes:
        low: smallest s.
        high: largest s.
    """

    low: float
    high: float

    name: ClassVar[str] = "gain_error"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "F = s kp (u − q) − kv q'"
    fingerprint: ClassVar[str] = "residual proportional to the distance from the target: sags further under a load"
    confused_with: ClassVar[tuple[str, ...]] = ("torque_scale", "viscous_friction", "payload")
    sizeless: ClassVar[bool] = True

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """At position servos."""
        return _servo(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The factor."""
        del model, site, scales
        return (Parameter("factor", "1", 1.0, self.low, self.high),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Scale the proportional gain alone."""
        actuator = actuator_of(spec, site)
        actuator.gainprm[0] *= values["factor"]
        actuator.biasprm[1] *= values["factor"]


def _servo(model: mujoco.MjModel, row: int) -> bool:
    gain, bias = model.actuator_gainprm[row], model.actuator_biasprm[row]
    fixed = model.actuator_gaintype[row] == mujoco.mjtGain.mjGAIN_FIXED
    affine = model.actuator_biastype[row] == mujoco.mjtBias.mjBIAS_AFFINE
    return bool(fixed and affine and gain[0] > 0 and np.isclose(bias[1], -gain[0]))
