"""Dry friction as bristles that bend, slip, and hold less the faster they slip: LuGre's."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.bristles import Bristles
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Law
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class LugreFriction(JointEffect, ForceLaw):
    """LuGre friction: Stribeck's friction, whose bristles bend before they slip; viscous friction is separate.

    tau = −(tau_c + tau_e) (b + T b') with b' = (v − |v/g(v)| b)/x and
    g(v) = tanh(v/v_c) (1 − d (1 − exp(−(v/v_s)²))), d = tau_e/(tau_c + tau_e). While it slides steadily it is
    Stribeck's friction; at a reversal b follows over the way x. v_c, below which the joint creeps, is no parameter but
    a small share of v_s: tanh stands for the sign of v. For solving the equation see `Bristles`.
    MuJoCo's own LuGre friction (``dcmotor``) is not used: see `StribeckFriction`.

    Parameters (nominal = absent): kinetic tau_c ≥ 0 and excess tau_e ≥ 0 [N·m, slide: N]; speed v_s > 0 [rad/s, slide:
    m/s], which acts only where tau_e > 0; displacement x ≥ 0 [rad, slide: m], the bend at which resting bristles slip,
    and retardation T ≥ 0 [s], which act only where there is friction (fits start away from absent).
    Limits: hinge and slide joints. Before a window's start b follows the measured motion of ``windows.memory`` seconds,
    from b = 0.
    Source: Canudas de Wit, Olsson, Åström and Lischinsky, IEEE TAC 40 (1995), equations 1 to 4, with
    σ0 = (tau_c + tau_e)/x, σ1 = T σ0 and σ2 = 0.

    Attributes:
        factor: largest tau_c and tau_e, in units of the joint's torque in the logs.
        least: their smallest upper bound, for joints that hardly move [N·m or N].
        speeds: smallest, nominal and largest v_s, in units of the joint's speed in the logs.
        creep: v_c, in units of v_s.
        least_speed: smallest joint speed that is believed [rad/s or m/s].
        displacements: smallest, nominal and largest x, in units of the joint's range in the logs.
        least_range: smallest range that is believed [rad or m].
        retarded: largest T in s.
        start_torque: tau_c and tau_e of the fits that start away from absent, share of their upper bound.
        start_shapes: (v_s, x) of these fits, shares of the joint's speed and range.
    """

    factor: float
    least: float
    speeds: tuple[float, float, float]
    creep: float
    least_speed: float
    displacements: tuple[float, float, float]
    least_range: float
    retarded: float
    start_torque: float
    start_shapes: Sequence[tuple[float, float]]

    name: ClassVar[str] = "lugre_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -(tau_c + tau_e) b, b follows Stribeck's curve over the way x"
    fingerprint: ClassVar[str] = "force residual that builds up over a short way after a reversal and falls with speed"
    confused_with: ClassVar[tuple[str, ...]] = (
        "stribeck_friction",
        "presliding_friction",
        "coulomb_friction",
        "hysteresis",
    )
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "coulomb_friction": SpecialCase(("excess", "displacement", "retardation"), {"kinetic": "torque"}),
        "stribeck_friction": SpecialCase(
            ("displacement", "retardation"), {"kinetic": "kinetic", "excess": "excess", "speed": "speed"}
        ),
    }
    shapes: ClassVar[tuple[str, ...]] = ("speed", "displacement", "retardation")
    divisors: ClassVar[tuple[str, ...]] = ("speed",)
    lacks: ClassVar[str] = "the bristles, whose bend goes on from step to step"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The two torques, the Stribeck speed and the way over which bristles bend."""
        torque, angle, speed = ("N", "m", "m/s") if slides(model, site) else ("N·m", "rad", "rad/s")
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        slow, usual, fast = (s * max(scales.speed.get(site, 0.0), self.least_speed) for s in self.speeds)
        near, nominal, far = (s * max(scales.position.get(site, 0.0), self.least_range) for s in self.displacements)
        return (
            Parameter("kinetic", torque, 0.0, 0.0, high),
            Parameter("excess", torque, 0.0, 0.0, high),
            Parameter("speed", speed, usual, slow, fast),
            Parameter("displacement", angle, nominal, near, far),
            Parameter("retardation", "s", 0.0, 0.0, self.retarded),
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        excess, speed = values["excess"], values["speed"]
        static = values["kinetic"] + excess
        return _FallingBristles(
            dof=int(models[0].joint(site).dofadr[0]),
            torque=static,
            way=values["displacement"],
            creep=self.creep * speed,
            retardation=values["retardation"],
            drop=np.divide(excess, static, out=np.zeros_like(static), where=static > 0.0),
            speed=speed,
        )

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction of either kind, with several Stribeck speeds and ways."""
        kinetic, excess, speed, way, _ = parameters
        torques = {"kinetic": self.start_torque * kinetic.high, "excess": self.start_torque * excess.high}
        moving, moved = speed.high / self.speeds[2], way.high / self.displacements[2]
        return tuple(
            {**torques, "speed": slow * moving, "displacement": far * moved} for slow, far in self.start_shapes
        )


@dataclass
class _FallingBristles(Bristles):
    """Bristles that settle the less bent the faster they slip; values of shape (n,) or (1,).

    Attributes:
        drop: share of the torque that is lost at high speed.
        speed: around which it is lost, rad/s or m/s.
    """

    drop: Array
    speed: Array

    def settled(self, speed: Array) -> tuple[Array, Array]:
        bend, slope = super().settled(speed)
        kept = 1.0 - self.drop * (1.0 - np.exp(-((speed / self.speed) ** 2)))
        return bend * kept, slope * kept
