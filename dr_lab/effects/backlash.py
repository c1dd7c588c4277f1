"""Play between the teeth of a gear."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_drive import JointDrive
from dr_lab.effects.joint_effect import slides
from dr_lab.effects.motor_side import MotorSide, MotorSideEffect
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Law
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

# Share of its distance from the wall that a rotor in contact covers in a step, per step: with offsets that follow the
# mean of two rates this settles fastest without swinging (double root of λ² − (1 − b/2) λ + b/2).
_SETTLING = 6.0 - np.sqrt(32.0)


@dataclass(frozen=True)
class Backlash(MotorSideEffect, ForceLaw):
    """Teeth that part when the torque that they pass on turns round, and meet again across the gap.

    The distance δ of the motor before the link stays within ± gap/2. In between nothing is passed on: the link moves
    freely, the motor alone under its torque, J (δ'' + q'') = tau_m. At a wall, without rebound, both move as one for as
    long as the motor presses against it: the model itself. Walls act within some three steps of the simulation.
    Before a window's start the motor follows the measured motion and commands of ``windows.memory`` seconds. It begins
    at the wall against which it presses.

    Parameters (nominal = absent): gap ≥ 0 [rad, slide: m]; rotor J > 0 [kg·m², slide: kg], which acts only where there
    is a gap (fits start away from absent).
    Limits: driven hinge and slide joints whose encoder sits at the link; no friction of the motor itself. The link sees
    J/(J + J_link) of the gap; if the gap is crossed within a few samples, only that product is known.
    Source: Nordin and Gutman, Controlling mechanical systems with backlash — a survey, Automatica 38 (2002), section 2
    (two inertias, stiff shaft).

    Attributes:
        factor: largest gap, share of the joint's range in the logs.
        largest: bound of the gap for joints that turn far [rad or m].
        least_range: smallest range that is believed [rad or m].
        closed: gap up to which the motor crosses without a free flight, in some three steps [rad or m]. So a gap that
            closes turns into none continuously; with free flights of single steps it would not.
        start_gaps: gaps of the fits that start away from absent, shares of the largest.
    """

    factor: float
    largest: float
    least_range: float
    closed: float
    start_gaps: tuple[float, ...]

    name: ClassVar[str] = "backlash"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "J (delta'' + q'') = tau_m while |delta| < gap/2, else rigid"
    fingerprint: ClassVar[str] = "the link coasts and is hit whenever the torque that it takes turns round"
    confused_with: ClassVar[tuple[str, ...]] = ("joint_elasticity", "dead_zone", "hysteresis", "actuator_delay")
    shapes: ClassVar[tuple[str, ...]] = ("rotor",)
    divisors: ClassVar[tuple[str, ...]] = ("rotor",)
    lacks: ClassVar[str] = "the motor that turns freely within the gap; the file holds it rigid with its link"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Gap and rotor."""
        high = min(self.factor * max(scales.position.get(site, 0.0), self.least_range), self.largest)
        gap = Parameter("gap", "m" if slides(model, site) else "rad", 0.0, 0.0, high)
        return gap, self.rotor(model, site)

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The motor in its gap."""
        drive, step = JointDrive.of(models, site), float(models[0].opt.timestep)
        return self.motor_law()(drive, step, values["rotor"], 0.5 * values["gap"], 0.5 * self.closed)

    def motor_law(self) -> "type[Parting]":
        """Of a motor and its link."""
        return Parting

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Small and larger gaps."""
        gap = parameters[0]
        return tuple({"gap": share * gap.high} for share in self.start_gaps)


@dataclass
class Parting(MotorSide):
    """Rotor between two walls at ± reach, shape (n,) or (1,); up to a reach of closed it always touches one."""

    reach: Array
    closed: float

    kept: ClassVar[tuple[str, ...]] = (*MotorSide.kept, "_free", "_kick")

    def balance(self, load: Array) -> Array:
        """At the wall that the load presses it against."""
        return np.sign(load) * self.reach

    def plan(self, load: Array) -> tuple[Array, Array]:
        """Free if the step ends between the walls, else towards the wall."""
        reached = self.offset + self.step * (self.rate + 0.5 * self.step * load / self.inertia)
        wide = self.reach > self.closed
        self._free = wide & (np.abs(reached) < self.reach)
        wall = np.copysign(self.reach, np.where(wide, reached, load))
        settling = _SETTLING * (wall - self.offset) / self.step - self.rate
        self._kick = np.where(self._free, 0.0, settling)
        return self._free.astype(float), self._kick

    def advance(self, load: Array) -> None:
        """Freely under the load, or at the wall as planned."""
        gained = np.where(self._free, self.step * load / self.inertia, self._kick)
        self.offset = self.offset + self.step * (self.rate + 0.5 * gained)
        self.rate = self.rate + gained
