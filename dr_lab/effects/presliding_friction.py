"""Dry friction that gives way before it slides, and that creeps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco

from dr_lab.effects.bristles import Bristles
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Law
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class PreslidingFriction(JointEffect, ForceLaw):
    """Dry friction as bristles that bend before they slip, and slip a little under any load.

    tau = −tau_c (b + T b') with b' = (v − |v/g(v)| b)/x and g(v) = tanh(v/v_c): LuGre's bristles without Stribeck's
    drop. While it slides steadily b is g(v), so that the joint creeps at speeds below v_c; at a reversal b follows over
    the way x. For v_c, T → 0 it is Dahl's friction, for x, T → 0 `SmoothFriction`, for all of them Coulomb friction.
    For solving the equation see `Bristles`.
    MuJoCo's own LuGre friction (``dcmotor``) is not used: see `StribeckFriction`. Nor is a softer friction constraint
    (``solref_friction``), which creeps at a speed that depends on the inertia and the time step.

    Parameters (nominal = absent): torque tau_c ≥ 0 [N·m, slide: N]; displacement x ≥ 0 [rad, slide: m], creep
    v_c > 0 [rad/s, slide: m/s] and retardation T ≥ 0 [s], which act only where tau_c > 0 (fits start away from absent).
    Limits: hinge and slide joints; no Stribeck drop. Before a window's start b follows the measured motion of
    ``windows.memory`` seconds, from b = 0.
    Source: Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968); Canudas de Wit, Olsson, Åström and
    Lischinsky, IEEE TAC 40 (1995), equations 1 to 3, with σ0 = tau_c/x and σ1 = T σ0.

    Attributes:
        factor: largest tau_c, in units of the joint's torque in the logs.
        least: its smallest upper bound, for joints that hardly move [N·m or N].
        displacements: smallest, nominal and largest x, in units of the joint's range in the logs.
        least_range: smallest range that is believed [rad or m].
        creeps: smallest, nominal and largest v_c, in units of the joint's speed in the logs.
        least_speed: smallest joint speed that is believed [rad/s or m/s].
        retarded: largest T in s.
        start_torque: tau_c of the fits that start away from absent, share of its upper bound.
        start_shapes: (x, v_c) of these fits, shares of the joint's range and speed.
    """

    factor: float
    least: float
    displacements: tuple[float, float, float]
    least_range: float
    creeps: tuple[float, float, float]
    least_speed: float
    retarded: float
    start_torque: float
    start_shapes: Sequence[tuple[float, float]]

    name: ClassVar[str] = "presliding_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "tau = -tau_c (b + T b'), b follows tanh(v/v_c) over the way x"
    fingerprint: ClassVar[str] = "force residual that changes its sign over a short way after a reversal; no true rest"
    confused_with: ClassVar[tuple[str, ...]] = (
        "coulomb_friction",
        "stribeck_friction",
        "lugre_friction",
        "smooth_friction",
        "soft_friction",
        "hysteresis",
        "viscous_friction",
    )
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "coulomb_friction": SpecialCase(("displacement", "creep", "retardation"), {"torque": "torque"}),
        "smooth_friction": SpecialCase(("displacement", "retardation"), {"torque": "torque", "creep": "creep"}),
    }
    shapes: ClassVar[tuple[str, ...]] = ("displacement", "creep", "retardation")
    divisors: ClassVar[tuple[str, ...]] = ("creep",)
    sharpened: ClassVar[tuple[str, ...]] = ("creep",)
    lacks: ClassVar[str] = "the bristles, whose bend goes on from step to step"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The torque while sliding, the way over which it builds up, the speed below which it creeps, and damping."""
        torque, angle, speed = ("N", "m", "m/s") if slides(model, site) else ("N·m", "rad", "rad/s")
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        moved = max(scales.position.get(site, 0.0), self.least_range)
        moving = max(scales.speed.get(site, 0.0), self.least_speed)
        low, nominal, far = (share * moved for share in self.displacements)
        slow, usual, fast = (share * moving for share in self.creeps)
        return (
            Parameter("torque", torque, 0.0, 0.0, high),
            Parameter("displacement", angle, nominal, low, far),
            Parameter("creep", speed, usual, slow, fast),
            Parameter("retardation", "s", 0.0, 0.0, self.retarded),
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        dof = int(models[0].joint(site).dofadr[0])
        way, creep, retardation = values["displacement"], values["creep"], values["retardation"]
        return Bristles(dof, values["torque"], way, creep, retardation=retardation)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction that gives way over several ways and creeps at several speeds."""
        torque, way, creep, _ = parameters
        moved, moving = way.high / self.displacements[2], creep.high / self.creeps[2]
        little = self.start_torque * torque.high
        return tuple(
            {"torque": little, "displacement": far * moved, "creep": slow * moving} for far, slow in self.start_shapes
        )
