"""A drive that delivers another force than its data sheet says."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect, actuator_of
from dr_lab.effects.effect import Scales
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter

_AFFINE_GAIN = (mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtGain.mjGAIN_AFFINE)
_AFFINE_BIAS = (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)


@dataclass(frozen=True)
class TorqueScale(ActuatorEffect, SpecEdit):
    """A weaker magnet, a gear's loss or a wrong unit: the actuator's whole force times a factor.

    F = s F_model, force limit included. Affine actuators: gain and bias times s. DC motors, F = K (u − K v)/R: R/s,
    which scales the driving torque and the braking by the back-EMF alike; the electrical time constant stays. A gear
    whose ratio is r times the model's is a factor r for an actuator that is a torque, and a `sensor_scale` of r − 1
    besides where the encoder sits at the motor.

    Parameters (nominal = absent): factor s > 0, 1 = absent.
    Limits: actuators whose force is affine, and DC motors with a voltage input alone (no controller, cogging, LuGre or
    thermal model); not separable from the masses where all of them and the frictions are free.
    Source: MuJoCo 4.0, XML reference, actuator/general (gainprm, biasprm) and actuator/dcmotor.

    Attributes:
        low: smallest s.
        high: largest s.
    """

    low: float
    high: float

    name: ClassVar[str] = "torque_scale"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "F = s F_model"
    fingerprint: ClassVar[str] = "residual proportional to the driven part of the motion at every speed and frequency"
    confused_with: ClassVar[tuple[str, ...]] = ("armature", "payload", "viscous_friction")
    argument: ClassVar[str] = "command"
    sizeless: ClassVar[bool] = True

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """Where the force can be scaled."""
        return _scalable(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The factor."""
        del model, site, scales
        return (Parameter("factor", "1", 1.0, self.low, self.high),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Scale the force law and the force limit."""
        actuator, factor = actuator_of(spec, site), values["factor"]
        if actuator.gaintype == mujoco.mjtGain.mjGAIN_DCMOTOR:
            actuator.gainprm[0] /= factor  # resistance
            actuator.dynprm[1] *= factor  # limit of the current's rate
        else:
            actuator.gainprm[:3] *= factor
            actuator.biasprm[:3] *= factor
        actuator.forcerange = np.asarray(actuator.forcerange) * factor


def _scalable(model: mujoco.MjModel, row: int) -> bool:
    gain, bias = int(model.actuator_gaintype[row]), int(model.actuator_biastype[row])
    if gain == int(mujoco.mjtGain.mjGAIN_DCMOTOR) and bias == int(mujoco.mjtBias.mjBIAS_DCMOTOR):
        extras = (model.actuator_gainprm[row, 2:], model.actuator_biasprm[row], model.actuator_dynprm[row, 2:])
        return not any(np.any(values) for values in extras)
    return gain in map(int, _AFFINE_GAIN) and bias in map(int, _AFFINE_BIAS)
