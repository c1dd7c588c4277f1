"""Friction that is larger at first and falls while the machine warms up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.dry_friction import DryFrictionEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FrictionDrift(DryFrictionEffect, ForceLaw):
    """Grease that is stiff and a seal that sticks until they are warm: friction beside the joint's own that fades.

    tau(v, t) = −(tau_c sign(v) + c v) exp(−r t) with t on the log's clock, |tau| ≤ tau_c exp(−r t) at rest. What is
    left when it is warm is the joint's own friction, or that of other effects.

    Parameters (nominal = absent): dry tau_c ≥ 0 [N·m, slide: N] and viscous c ≥ 0 [N·m·s/rad, slide: N·s/m], both at
    time zero; rate r ≥ 0 [1/s], the inverse of the time constant, which acts only where one of these is above 0.
    Limits: hinge and slide joints; every log begins as cold as the others. With r = 0 it is Coulomb and viscous
    friction; logs much shorter than 1/r cannot tell it from these. A viscosity that the step cannot follow diverges.
    Source: Simoni, Beschi, Legnani and Visioli, Friction modeling with temperature effects for industrial robot
    manipulators, IROS 2015 (exponential settling of friction with the joint's temperature).

    Attributes:
        constraint: how hard the friction constraint is.
        dry_factor: largest tau_c, in units of the joint's torque in the logs.
        viscous_factor: largest c, in units of the joint's torque/speed in the logs.
        least: smallest upper bound of both, for joints that hardly move [SI units].
        rates: smallest, nominal and largest r [1/s].
        start: tau_c and c of the fit that starts away from absent, shares of their upper bounds.
        start_rate: r of this fit [1/s].
    """

    dry_factor: float
    viscous_factor: float
    least: float
    rates: tuple[float, float, float]
    start: tuple[float, float]
    start_rate: float

    name: ClassVar[str] = "friction_drift"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -(tau_c sign(v) + c v) exp(-r t)"
    fingerprint: ClassVar[str] = "force residual against the motion, large as each log begins, that fades"
    confused_with: ClassVar[tuple[str, ...]] = ("coulomb_friction", "viscous_friction")
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "coulomb_friction": SpecialCase(("viscous", "rate"), {"dry": "torque"}),
        "viscous_friction": SpecialCase(("dry", "rate"), {"viscous": "coefficient"}),
    }
    shapes: ClassVar[tuple[str, ...]] = ("rate",)
    lacks: ClassVar[str] = "the friction that fades with the time since the log began"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Dry and viscous friction when cold, and the rate at which they fade."""
        torque, speed = scales.torque.get(site, 0.0), scales.speed.get(site, 0.0)
        dry = max(self.dry_factor * torque, self.least)
        viscous = max(self.viscous_factor * torque / speed if speed else 0.0, self.least)
        units = ("N", "N·s/m") if slides(model, site) else ("N·m", "N·m·s/rad")
        low, nominal, high = self.rates
        return (
            Parameter("dry", units[0], 0.0, 0.0, dry),
            Parameter("viscous", units[1], 0.0, 0.0, viscous),
            Parameter("rate", "1/s", nominal, low, high),
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """Friction loss and force of each step."""
        return _Fading(int(models[0].joint(site).dofadr[0]), values["dry"], values["viscous"], values["rate"])

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction of both kinds that fades fast."""
        dry, viscous, _ = parameters
        share, grease = self.start
        return ({"dry": share * dry.high, "viscous": grease * viscous.high, "rate": self.start_rate},)


@dataclass(frozen=True)
class _Fading(Law):
    """Friction of a degree of freedom that fades; values of shape (n,)."""

    dof: int
    dry: Array
    viscous: Array
    rate: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        left = np.exp(-self.rate * moment.time)
        influence.friction[:, self.dof] += self.dry * left
        influence.force[:, self.dof] -= self.viscous * left * moment.qvel[:, self.dof]
