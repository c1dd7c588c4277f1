"""Commands that the driver follows at a limited rate."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect
from dr_lab.effects.command_filter import Advance, DynamicFilter
from dr_lab.effects.effect import Scales
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class RateLimit(ActuatorEffect, DynamicFilter):
    """A driver's ramp or a hydraulic valve: the command takes its time over every change.

    |y'| ≤ 1/i on the way from y to the command u, where it stops. Through a step h in which u is held, y goes
    f = min(1, h/(i |u − y|)) of its way, and f (1 − min(i |u − y|, h)/(2 h)) of it on average. The parameter is the
    inverse of the limit, so that absent is a finite value.

    Parameters (nominal = absent): inverse_rate i ≥ 0 [s per unit of the command].
    Limits: actuators with one command; symmetric; before the windows' past it is at rest. Acts on step averages, so a
    jump within a step counts as two lesser ones. Every jump shows it; a command without jumps shows it only if it is
    steeper than 1/i, so fits start at several limits.
    MuJoCo's ``slewmax`` is not used: it limits position setpoints alone, and its activation at a window's start
    would be one more unknown.
    Source: Duda, Journal of Guidance, Control, and Dynamics 20 (1997), 581-587.

    Attributes:
        slowest: longest time over the largest command in the logs [s].
        least: smallest command that is believed [unit of the command].
        start_times: times over the largest command of the fits that start away from absent [s].
    """

    slowest: float
    least: float
    start_times: tuple[float, ...]

    name: ClassVar[str] = "rate_limit"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "|y'| <= limit on the way to u"
    fingerprint: ClassVar[str] = "residual after jumps of the command, growing with the square of the jump"
    confused_with: ClassVar[tuple[str, ...]] = ("actuator_lag", "actuator_delay")
    lacks: ClassVar[str] = "the rate limit, through which commands go before they reach the actuator"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The inverse limit."""
        del model
        largest = max(scales.command.get(site, 0.0), self.least)
        return (Parameter("inverse_rate", "s/command", 0.0, 0.0, self.slowest / largest),)

    def advance(self, values: Mapping[str, Array], step: float) -> Advance:
        """Average and end of a step through which a command is held."""
        inverse = values["inverse_rate"]

        def limited(level: Array, asked: Array) -> tuple[Array, Array]:
            gap = asked - level
            time = inverse * np.abs(gap)
            share = step / np.maximum(time, step)
            end = asked - (1.0 - share) * gap
            return end - share * gap * np.minimum(time, step) / (2.0 * step), end

        return limited

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Limits within the commands of the logs."""
        (inverse,) = parameters
        return tuple({"inverse_rate": inverse.high * time / self.slowest} for time in self.start_times)
