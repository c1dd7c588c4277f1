"""Dry friction of constant size."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.dry_friction import DryFrictionEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import joint_of, slides
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class CoulombFriction(DryFrictionEffect, SpecEdit):
    """Dry friction: constant against the motion, and up to the same size against any force while at rest.

    tau = −tau_c sign(v) while sliding, |tau| ≤ tau_c at rest; MuJoCo's ``frictionloss``, made hard by `DryFriction`
    (the exported MJCF carries that as ``solreffriction`` and ``solimpfriction``).

    Parameters (nominal = absent): torque tau_c ≥ 0 [N·m, slide: N].
    Limits: hinge and slide joints; the same in both directions.
    Source: Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2; MuJoCo joint/frictionloss.

    Attributes:
        constraint: how hard the friction constraint is.
        factor: largest tau_c, in units of the joint's torque in the logs.
        least: smallest upper bound of tau_c, for joints that hardly move [N·m or N].
    """

    factor: float
    least: float

    name: ClassVar[str] = "coulomb_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -tau_c sign(v)"
    fingerprint: ClassVar[str] = "force residual jumps with the sign of velocity; swings decay linearly and then stop"
    confused_with: ClassVar[tuple[str, ...]] = (
        "stribeck_friction",
        "presliding_friction",
        "smooth_friction",
        "soft_friction",
        "viscous_friction",
    )

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The torque."""
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        return (Parameter("torque", "N" if slides(model, site) else "N·m", 0.0, 0.0, high),)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the torque to the joint's friction loss."""
        joint_of(spec, site).frictionloss += values["torque"]
