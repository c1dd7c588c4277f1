"""Dry friction that differs between the two directions."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.dry_friction import DryFrictionEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import add_passive_force, joint_of, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class AsymmetricFriction(DryFrictionEffect, SpecEdit):
    """Dry friction of a screw, seal or worm gear that runs more easily in one direction than in the other.

    tau = −tau_m (1 + s) while v > 0, tau = tau_m (1 − s) while v < 0, and anything between them at rest. The mean tau_m
    is MuJoCo's ``frictionloss``, made hard by `DryFriction`; an actuator without command
    (``asymmetric_friction@<joint>``) adds the constant force −s tau_m. The asymmetry is a share of the mean, so that
    friction never drives the joint.

    Parameters (nominal = absent): mean tau_m ≥ 0 [N·m, slide: N]; asymmetry s within ±1, which acts only where
    tau_m > 0 (fits start away from absent).
    Limits: hinge and slide joints; exactly Coulomb friction and a constant offset together.
    Source: Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2 (asymmetries of friction);
    Swevers, Verdonck and De Schutter, IEEE Control Systems 27 (2007), equation 4; MuJoCo joint/frictionloss.

    Attributes:
        constraint: how hard the friction constraint is.
        factor: largest tau_m, in units of the joint's torque in the logs.
        least: its smallest upper bound, for joints that hardly move [N·m or N].
        start_mean: tau_m of the fits that start away from absent, share of its upper bound.
        start_asymmetries: s of these fits.
    """

    factor: float
    least: float
    start_mean: float
    start_asymmetries: tuple[float, ...]

    name: ClassVar[str] = "asymmetric_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -tau_m (sign(v) + s)"
    fingerprint: ClassVar[str] = "force residual jumps with the sign of velocity, about a mean that is not zero"
    confused_with: ClassVar[tuple[str, ...]] = ("coulomb_friction", "stribeck_friction", "constant_offset")
    holds: ClassVar[Mapping[str, SpecialCase]] = {"coulomb_friction": SpecialCase(("asymmetry",), {"mean": "torque"})}
    shapes: ClassVar[tuple[str, ...]] = ("asymmetry",)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The mean of the two directions' torques, and the share by which they differ from it."""
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        unit = "N" if slides(model, site) else "N·m"
        return (Parameter("mean", unit, 0.0, 0.0, high), Parameter("asymmetry", "1", 0.0, -1.0, 1.0))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the mean to the joint's friction loss, and the force that takes from one direction what it gives."""
        joint, mean = joint_of(spec, site), values["mean"]
        joint.frictionloss += mean
        add_passive_force(spec, joint.name, f"{self.name}@{site}").biasprm[0] = -values["asymmetry"] * mean

    def together(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Friction alike in both directions, and a constant force, such as a counterweight's that is off."""
        return {"coulomb_friction": values["mean"], "constant_offset": -values["asymmetry"] * values["mean"]}

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction that is larger forwards or backwards."""
        mean = self.start_mean * parameters[0].high
        return tuple({"mean": mean, "asymmetry": share} for share in self.start_asymmetries)
