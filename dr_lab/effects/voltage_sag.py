"""A supply that gives way under load."""

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
class VoltageSag(ActuatorEffect, StaticFilter):
    """A battery's or a cable's resistance: the supply drops in proportion to the load, and the drive with it.

    u → u (1 − c |u|). At the largest command u_max the share k = c u_max of the supply is lost. The parameter is c and
    not k, so that its value holds for other logs too.

    Parameters (nominal = absent): slope c ≥ 0 [1/unit of the command].
    Limits: actuators with one command that are no position servos, whose zero is no load; the load is taken as
    proportional to the command (neither back-EMF nor other consumers of the same supply count). k ≤ ½ keeps larger
    commands larger.
    Source: Horowitz and Hill, The Art of Electronics, 3rd edition (2015), chapter 1 (Thévenin equivalent of a source).

    Attributes:
        deepest: largest k.
        least: smallest command that is believed [unit of the command].
    """

    deepest: float
    least: float

    name: ClassVar[str] = "voltage_sag"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "u -> u (1 - c |u|)"
    fingerprint: ClassVar[str] = "force residual proportional to the square of the command, against it"
    limited: ClassVar[tuple[str, ...]] = ("slope",)
    confused_with: ClassVar[tuple[str, ...]] = ("saturation", "command_power", "torque_scale", "quadratic_drag")
    argument: ClassVar[str] = "command"
    lacks: ClassVar[str] = "the supply's sag, which weakens commands before they reach the actuator"

    def acts_at(self, model: mujoco.MjModel, row: int) -> bool:
        """Where the force does not depend on position."""
        return idle_at_zero(model, row)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The slope."""
        del model
        largest = max(scales.command.get(site, 0.0), self.least)
        return (Parameter("slope", "1/command", 0.0, 0.0, self.deepest / largest),)

    def output(self, values: Mapping[str, Array], asked: Array) -> Array:
        """Commands less what the supply loses."""
        return asked * (1.0 - values["slope"] * np.abs(asked))
