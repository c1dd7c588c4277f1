"""Small commands that do nothing."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect, idle_at_zero
from dr_lab.effects.command_filter import StaticFilter
from dr_lab.effects.effect import Scales
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class DeadZone(ActuatorEffect, StaticFilter):
    """A driver's dead time, a valve's overlap or a brush's voltage drop: what is asked for first does nothing.

    u → sign(u) max(|u| − d, 0).

    Parameters (nominal = absent): width d ≥ 0 [unit of the command].
    Limits: actuators with one command that are no position servos, whose zero is no force (it would be a zone about the
    zero position); symmetric. Acts on step averages, so a command that changes within a step is off by less than d for
    that step.
    Source: Tao and Kokotović, Adaptive Control of Systems with Actuator and Sensor Nonlinearities (1996), chapter 2.

    Attributes:
        widest: largest d, in units of the largest command in the logs.
        least: smallest command that is believed [unit of the command].
    """

    widest: float
    least: float

    name: ClassVar[str] = "dead_zone"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "u -> sign(u) max(|u| - d, 0)"
    fingerprint: ClassVar[str] = "force residual jumps with the sign of the command, and grows no further with it"
    confused_with: ClassVar[tuple[str, ...]] = (
        "command_power",
        "coulomb_friction",
        "stribeck_friction",
        "torque_scale",
        "backlash",
    )
    argument: ClassVar[str] = "command"
    lacks: ClassVar[str] = "the dead zone, through which commands go before they reach the actuator"

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """Where the force does not depend on position."""
        return idle_at_zero(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The width."""
        del model
        largest = max(scales.command.get(site, 0.0), self.least)
        return (Parameter("width", "command", 0.0, 0.0, self.widest * largest),)

    def output(self, values: Mapping[str, Array], asked: Array) -> Array:
        """Commands less the width, towards zero."""
        return np.sign(asked) * np.maximum(np.abs(asked) - values["width"], 0.0)
