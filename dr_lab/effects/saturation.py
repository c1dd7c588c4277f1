"""A limit on what the driver makes of a command."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.actuator_effect import ActuatorEffect, actuator_of
from dr_lab.effects.effect import Scales
from dr_lab.effects.force_range import acts
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class Saturation(ActuatorEffect, SpecEdit):
    """A supply or driver that cannot give more than a limit.

    u → clip(u, −1/i, 1/i), within the actuator's own control range. The parameter is the inverse of the limit, so that
    absent is a finite value.

    Parameters (nominal = absent): inverse_limit i ≥ 0 [1/unit of the command].
    Limits: actuators with one command; symmetric. No slope at absent, nor anywhere below 1/(largest command): fits
    start at several limits within the commands of the logs.
    Source: MuJoCo 4.0, XML reference, actuator/general/ctrlrange.

    Attributes:
        deepest: smallest limit, in units of the largest command in the logs.
        least: smallest command that is believed [unit of the command].
        start_limits: limits of the fits that start away from absent, in units of the largest command in the logs.
    """

    deepest: float
    least: float
    start_limits: tuple[float, ...]

    name: ClassVar[str] = "saturation"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "u -> clip(u, -limit, limit)"
    fingerprint: ClassVar[str] = "residual only while the command is large"
    confused_with: ClassVar[tuple[str, ...]] = ("torque_scale", "command_power")
    argument: ClassVar[str] = "command"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The inverse limit."""
        del model
        largest = max(scales.command.get(site, 0.0), self.least)
        return (Parameter("inverse_limit", "1/command", 0.0, 0.0, 1.0 / (self.deepest * largest)),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Narrow the control range."""
        actuator = actuator_of(spec, site)
        if values["inverse_limit"] == 0:
            return
        limit = 1.0 / values["inverse_limit"]
        low, high = actuator.ctrlrange if acts(spec, actuator.ctrllimited, actuator.ctrlrange) else (-limit, limit)
        actuator.ctrlrange = [max(low, -limit), min(high, limit)]
        actuator.ctrllimited = mujoco.mjtLimited.mjLIMITED_TRUE

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Limits within the commands of the logs."""
        (inverse,) = parameters
        return tuple({"inverse_limit": inverse.high * self.deepest / share} for share in self.start_limits)
