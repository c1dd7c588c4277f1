"""Small commands that do nothing."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect
from dr_lab.effects.command_filter import Driver, column_of
from dr_lab.effects.effect import Scales
from dr_lab.physics.law import Law
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class DeadZone(ActuatorEffect):
    """A driver's dead time, a valve's overlap or a brush's voltage drop: what is asked for first does nothing.

    u → sign(u) max(|u| − d, 0).

    Parameters (nominal = absent): width d ≥ 0 [unit of the command].
    Limits: actuators with one command, whose zero is no force (of a position servo it would be a zone about the zero
    position); symmetric. Acts on step averages, so a command that changes within a step is off by less than d for
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
    confused_with: ClassVar[tuple[str, ...]] = ("coulomb_friction", "stribeck_friction", "torque_scale", "backlash")
    argument: ClassVar[str] = "command"
    lacks: ClassVar[str] = "the dead zone, through which commands go before they reach the actuator"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The width."""
        del model
        largest = max(scales.command.get(site, 0.0), self.least)
        return (Parameter("width", "command", 0.0, 0.0, self.widest * largest),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Nothing: MuJoCo has no such element."""

    def command(
        self, site: str, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption
    ) -> Array:
        """Commands less the width, towards zero."""
        del option
        return _beyond(series, values["width"]) if actuator == site else series

    def drivers(self, site: str, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """The same at every step."""
        return (Driver(column_of(compiled, site), lambda _, asked: (_beyond(asked, values["width"]), asked)),)


def _beyond(command: Array, width: Array) -> Array:
    return np.sign(command) * np.maximum(np.abs(command) - width, 0.0)
