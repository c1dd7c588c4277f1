"""Dry friction that drops from static to kinetic as the joint starts to move."""

from collections.abc import Mapping, Sequence
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
class StribeckFriction(DryFrictionEffect, SpecEdit):
    """Dry friction that drops from static to kinetic as the joint starts to move; viscous friction is separate.

    tau(v) = −sign(v) (tau_c + tau_e exp(−(v/v_s)²)) while sliding, |tau| ≤ tau_c + tau_e at rest.
    It is written as a friction loss tau_c + tau_e, less forces along the motion that are proportional to speed and
    clipped. Their sum Σ share_i min(|v|/(width_i v_s), 1) stands for the drop 1 − exp(−(v/v_s)²). They are actuators
    without command (``stribeck_friction@<joint>.<i>``), present at every value; there is no hidden state.
    MuJoCo's own LuGre friction is not used: with RK4 its bristles diverge, with implicitfast its error is four times
    larger (notes in the yaml), and its damping kicks the joint at the start of every simulation.

    Parameters (nominal = absent): kinetic tau_c ≥ 0 and excess tau_e ≥ 0 [N·m, slide: N]; speed v_s > 0 [rad/s, slide:
    m/s], which acts only where tau_e > 0 (fits start away from absent).
    Limits: hinge and slide joints; a v_s that the joint passes within a few physics steps cannot be identified.
    Source: Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2; Canudas de Wit, Olsson,
    Åström and Lischinsky, IEEE TAC 40 (1995) for LuGre, whose steady state this is.

    Attributes:
        constraint: how hard the friction constraint is.
        clips: (share, width) of each clipped force; the shares add up to 1.
        factor: largest tau_c and tau_e, in units of the joint's torque in the logs.
        least: their smallest upper bound, for joints that hardly move [N·m or N].
        speeds: smallest, nominal and largest v_s, in units of the joint's speed in the logs.
        least_speed: smallest joint speed that is believed [rad/s or m/s].
        start_torque: tau_c and tau_e of the fits that start away from absent, share of their upper bound.
        start_speeds: v_s of these fits, shares of the joint's speed.
    """

    clips: Sequence[tuple[float, float]]
    factor: float
    least: float
    speeds: tuple[float, float, float]
    least_speed: float
    start_torque: float
    start_speeds: tuple[float, ...]

    name: ClassVar[str] = "stribeck_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -sign(v) (tau_c + tau_e exp(-(v/v_s)^2))"
    fingerprint: ClassVar[str] = "force residual jumps at reversals and falls with speed; the joint sticks, then slips"
    confused_with: ClassVar[tuple[str, ...]] = (
        "coulomb_friction",
        "lugre_friction",
        "presliding_friction",
        "viscous_friction",
    )
    holds: ClassVar[Mapping[str, SpecialCase]] = {"coulomb_friction": SpecialCase(("excess",), {"kinetic": "torque"})}
    shapes: ClassVar[tuple[str, ...]] = ("speed",)
    divisors: ClassVar[tuple[str, ...]] = ("speed",)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The two torques and the Stribeck speed."""
        slide = slides(model, site)
        torque, speed = ("N", "m/s") if slide else ("N·m", "rad/s")
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        low, nominal, fast = (s * max(scales.speed.get(site, 0.0), self.least_speed) for s in self.speeds)
        return (
            Parameter("kinetic", torque, 0.0, 0.0, high),
            Parameter("excess", torque, 0.0, 0.0, high),
            Parameter("speed", speed, nominal, low, fast),
        )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Add the static torque to the friction loss, and the forces that take the excess back."""
        joint, excess = joint_of(spec, site), values["excess"]
        joint.frictionloss += values["kinetic"] + excess
        for i, (share, width) in enumerate(self.clips):
            force = add_passive_force(spec, joint.name, f"{self.name}@{site}.{i}")
            force.biasprm[2] = share * excess / (width * values["speed"])
            limit = abs(share) * (excess or 1.0)  # MuJoCo rejects an empty range; without excess the force is 0 anyway
            force.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
            force.forcerange = [-limit, limit]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction of either kind, with several Stribeck speeds."""
        kinetic, excess, speed = parameters
        torques = {"kinetic": self.start_torque * kinetic.high, "excess": self.start_torque * excess.high}
        return tuple({**torques, "speed": share * speed.high / self.speeds[2]} for share in self.start_speeds)
