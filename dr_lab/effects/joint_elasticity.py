"""A shaft, belt or harmonic drive that twists between motor and link."""

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

_STIFFEST = 1e-6  # steps; the shortest period that rounding lets the closed forms tell from none


@dataclass(frozen=True)
class JointElasticity(MotorSideEffect, ForceLaw):
    """Two inertias with a spring in between: motor and link swing against each other.

    T = (δ + eta δ')/C with the distance δ of the motor before the link; J δ'' = tau_m − T − J q'', and the link, which
    carries the rest of the model's inertia, feels T. Without damping they swing at ω² = (1/J + 1/J_link)/C. For C → 0
    the motor is rigid with its link: the model itself.

    Each step is the exact solution for its mean tau_m and q'', so that no stiffness is too high for it. Before a
    window's start the motor follows the measured motion and commands of ``windows.memory`` seconds, from its balance.
    An oscillation that lasts longer, or is too fast for the smoothed measurement, begins wrong.

    Parameters (nominal = absent): compliance C ≥ 0 [rad/(N·m), slide: m/N]; rotor J > 0 [kg·m², slide: kg] and
    retardation eta > 0 [s], which act only where C > 0 (fits start away from absent).
    Limits: driven hinge and slide joints whose encoder sits at the link; the motor's back-EMF and friction stay with
    the link; logs without anything near the resonance tell only the product J C.
    Source: Spong, Modeling and control of elastic joint robots, ASME J. Dyn. Sys. Meas. Control 109 (1987), whose
    rotor turns about the joint's axis without gyroscopic coupling; damping after Kelvin and Voigt.

    Attributes:
        deflection: largest twist under the joint's torque in the logs, share of the joint's range there.
        largest: bound of that twist for joints that turn far [rad or m].
        least: smallest torque and range that are believed [N·m or N, rad or m].
        retardations: smallest, nominal and largest eta [s].
        start_deflections: twists of the fits that start away from absent, shares of the largest.
    """

    deflection: float
    largest: float
    least: tuple[float, float]
    retardations: tuple[float, float, float]
    start_deflections: tuple[float, ...]

    name: ClassVar[str] = "joint_elasticity"
    family: ClassVar[str] = "transmission"
    law: ClassVar[str] = "J delta'' = tau_m - T - J q'', T = (delta + eta delta')/C"
    fingerprint: ClassVar[str] = (
        "residual that rings at one frequency after jumps of the command; the link answers late"
    )
    confused_with: ClassVar[tuple[str, ...]] = (
        "motor_side_elasticity",
        "backlash",
        "actuator_delay",
        "actuator_lag",
        "armature",
    )
    shapes: ClassVar[tuple[str, ...]] = ("rotor", "retardation")
    sharpened: ClassVar[tuple[str, ...]] = ("retardation",)
    lacks: ClassVar[str] = "the motor that turns against its link on a spring; the file holds them rigid"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Compliance, rotor and damping."""
        torque, moved = (
            max(scale.get(site, 0.0), least)
            for scale, least in zip((scales.torque, scales.position), self.least, strict=True)
        )
        high = min(self.deflection * moved, self.largest) / torque
        low, nominal, far = self.retardations
        return (
            Parameter("compliance", "m/N" if slides(model, site) else "rad/(N·m)", 0.0, 0.0, high),
            self.rotor(model, site),
            Parameter("retardation", "s", nominal, low, far),
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The motor on its spring."""
        drive, step = JointDrive.of(models, site), float(models[0].opt.timestep)
        return self.motor_law()(drive, step, values["rotor"], values["compliance"], values["retardation"])

    def motor_law(self) -> "type[Twisting]":
        """Of a motor and its link."""
        return Twisting

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Springs from stiff to soft."""
        compliance = parameters[0]
        return tuple({"compliance": share * compliance.high} for share in self.start_deflections)


@dataclass
class Twisting(MotorSide):
    """Spring and damper between rotor and link; compliance and retardation of shape (n,) or (1,)."""

    compliance: Array
    retardation: Array

    def __post_init__(self) -> None:
        """Responses of δ and δ' over one step to an offset and to a rate at its start.

        δ'' + eta ω² δ' + ω² δ = 0 with ω² = 1/(C J); roots −a ± r with a = eta ω²/2.
        """
        square = 1.0 / np.maximum(self.compliance * self.inertia, (_STIFFEST * self.step) ** 2)
        a = 0.5 * self.retardation * square
        r = np.sqrt((a**2 - square).astype(complex))
        r = np.where(np.abs(r) < _STIFFEST * a, _STIFFEST * a, r)  # equal roots
        slow, fast = -square / (a + r), -(a + r)
        ends = np.exp(slow * self.step), np.exp(fast * self.step)
        elastic = self.compliance > 0
        self._offset_of_offset = np.where(elastic, ((slow * ends[1] - fast * ends[0]) / (2 * r)).real, 0.0)
        self._offset_of_rate = np.where(elastic, ((ends[0] - ends[1]) / (2 * r)).real, 0.0)
        self._rate_of_offset = -square * self._offset_of_rate
        self._rate_of_rate = np.where(elastic, ((slow * ends[0] - fast * ends[1]) / (2 * r)).real, 0.0)

    def balance(self, load: Array) -> Array:
        """C times the load."""
        return self.compliance * load

    def plan(self, load: Array) -> tuple[Array, Array]:
        """Of the closed form, in which the load enters through the share alone."""
        kick = self._rate_of_offset * self.offset + (self._rate_of_rate - 1.0) * self.rate
        return self._offset_of_rate / self.step, kick

    def advance(self, load: Array) -> None:
        """By the closed form."""
        centre = self.compliance * load
        off, rate = self.offset - centre, self.rate
        self.offset = centre + self._offset_of_offset * off + self._offset_of_rate * rate
        self.rate = self._rate_of_offset * off + self._rate_of_rate * rate
