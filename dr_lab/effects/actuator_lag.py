"""Commands that act gradually."""

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

_SHORTEST = np.finfo(np.float64).tiny  # s; in place of zero, by which nothing can be divided


@dataclass(frozen=True)
class ActuatorLag(ActuatorEffect, DynamicFilter):
    """A driver's filter, a coil's inductance or a valve: the command arrives through a first-order lag.

    tau y' = u − y, and y takes the command's place. Exact for a command u that is held through a step h:
    y(h) = u + (y(0) − u) exp(−h/tau), with the average u + (y(0) − u) (tau/h) (1 − exp(−h/tau)) through the step.

    MuJoCo's ``filterexact`` is not used, for three reasons:

    1. First-order integrators, with which it is exact, read it at the step's start, half a step late.
    2. RK4 takes linear stages of it, which overshoot by h/tau (steps of 2 ms: 4 % off at a tau of 10 ms, 24 % at 2 ms,
       unstable at 0.5 ms). Absent would be out of reach.
    3. Its activation at a window's start would be one more unknown. Here the earlier commands tell it.

    Parameters (nominal = absent): tau ≥ 0 [s].
    Limits: actuators with one command; the windows' past must cover some five tau, before which the lag is at rest.
    Source: Franklin, Powell and Workman, Digital Control of Dynamic Systems (zero-order hold equivalents).

    Attributes:
        longest: largest tau [s].
    """

    longest: float

    name: ClassVar[str] = "actuator_lag"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "tau y' = u - y"
    fingerprint: ClassVar[str] = "residual decays after every jump of the command; else like a delay of tau"
    confused_with: ClassVar[tuple[str, ...]] = (
        "actuator_delay",
        "sensor_low_pass",
        "sensor_time_offset",
        "joint_elasticity",
    )
    sizeless: ClassVar[bool] = True
    lacks: ClassVar[str] = "the lag, through which commands go before they reach the actuator"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The time constant."""
        del model, site, scales
        return (Parameter("tau", "s", 0.0, 0.0, self.longest),)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """A fifth of the commands that are kept: 0.7 % of what was before is left then."""
        del name, margin
        return 0.2 * kept

    def advance(self, values: Mapping[str, Array], step: float) -> Advance:
        """Average and end of a step, exact for a command that is held through it."""
        tau = values["tau"]
        end = np.exp(-step / np.maximum(tau, _SHORTEST))
        mean = tau / step * (1.0 - end)

        def lagging(level: Array, asked: Array) -> tuple[Array, Array]:
            gap = level - asked
            return asked + mean * gap, asked + end * gap

        return lagging
