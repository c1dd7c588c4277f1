"""A force that grows with a power of the command."""

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

_TINY = 1e-300  # of the full command; a power of zero is not a number where the exponent is below 1


@dataclass(frozen=True)
class CommandPower(ActuatorEffect, StaticFilter):
    """A propeller, a valve or a solenoid: twice the command is not twice the force.

    u → u |u/f|^(p − 1). Right at the full command f; of a propeller p is 2, so that less than f gives too little.

    Parameters (nominal = absent): exponent p > 0, 1 = absent; full f > 0 [unit of the command], which acts only where p
    is not 1 (fits start away from absent).
    Limits: actuators with one command that are no position servos, whose zero is no force; symmetric. Acts on step
    averages, so a command that changes within a step is off for that step. Where a factor on the force is free as well,
    as the torque scale or all masses and frictions, f cannot be told from it.
    Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), section 9.1 (thrust of a propeller
    at low speed of advance, T ∝ n |n|).

    Attributes:
        exponents: smallest and largest p.
        fulls: smallest, nominal and largest f, in units of the largest command in the logs.
        least: smallest command that is believed [unit of the command].
        start_exponents: p of the fits that start away from absent.
    """

    exponents: tuple[float, float]
    fulls: tuple[float, float, float]
    least: float
    start_exponents: tuple[float, ...]

    name: ClassVar[str] = "command_power"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "u -> u |u/full|^(exponent - 1)"
    fingerprint: ClassVar[str] = "force residual that is none at no command and at the full one, and largest between"
    confused_with: ClassVar[tuple[str, ...]] = ("dead_zone", "saturation", "torque_scale", "voltage_sag")
    shapes: ClassVar[tuple[str, ...]] = ("full",)
    divisors: ClassVar[tuple[str, ...]] = ("full",)
    limited: ClassVar[tuple[str, ...]] = ("exponent",)
    argument: ClassVar[str] = "command"
    lacks: ClassVar[str] = "the power law, through which commands go before they reach the actuator"

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """Where the force does not depend on position."""
        return idle_at_zero(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The exponent, and the command at which the force is right."""
        del model
        largest = max(scales.command.get(site, 0.0), self.least)
        low, nominal, high = (share * largest for share in self.fulls)
        return (Parameter("exponent", "1", 1.0, *self.exponents), Parameter("full", "command", nominal, low, high))

    def output(self, values: Mapping[str, Array], asked: Array) -> Array:
        """The power of commands."""
        return asked * np.maximum(np.abs(asked) / values["full"], _TINY) ** (values["exponent"] - 1.0)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Several exponents, right at the largest command."""
        _, full = parameters
        return tuple({"exponent": power, "full": full.nominal} for power in self.start_exponents)
