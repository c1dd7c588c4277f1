"""Dry friction that depends on where in its turn a joint stands."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.dry_friction import DryFrictionEffect
from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import require_place, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class PositionDependentFriction(DryFrictionEffect, ForceLaw):
    """Dry friction of a bent shaft, an eccentric gear or a worn bearing: once in a turn it is largest.

    |tau| ≤ tau_m max(0, 1 + a sin(q) + b cos(q)), against the motion. Written into MuJoCo's ``frictionloss`` before
    every step, made hard by `DryFriction`.

    Parameters (nominal = absent): mean tau_m ≥ 0 [N·m]; sine a and cosine b within ±1, which act only where tau_m > 0
    (fits start away from absent).
    Limits: hinge joints that turn far enough to tell a, b and tau_m apart.
    Source: Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2 (dependence on position).

    Attributes:
        constraint: how hard the friction constraint is.
        factor: largest tau_m, in units of the joint's torque in the logs.
        least: its smallest upper bound, for joints that hardly move [N·m].
        start_mean: tau_m of the fits that start away from absent, share of its upper bound.
        start_shares: (a, b) of these fits.
    """

    factor: float
    least: float
    start_mean: float
    start_shares: Sequence[tuple[float, float]]

    name: ClassVar[str] = "position_dependent_friction"
    family: ClassVar[str] = "friction"
    law: ClassVar[str] = "|tau| <= tau_m (1 + a sin(q) + b cos(q))"
    fingerprint: ClassVar[str] = "force residual jumps with the sign of velocity, by an amount that repeats every turn"
    confused_with: ClassVar[tuple[str, ...]] = ("coulomb_friction", "asymmetric_friction")
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "coulomb_friction": SpecialCase(("sine", "cosine"), {"mean": "torque"})
    }
    shapes: ClassVar[tuple[str, ...]] = ("sine", "cosine")
    lacks: ClassVar[str] = "the friction loss of the joint that follows its position from step to step"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the hinge joints."""
        return tuple(joint for joint in super().sites(model) if not slides(model, joint))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The mean, and the two phases of its change in shares of it."""
        require_place(model, site, scales)
        high = max(self.factor * scales.torque.get(site, 0.0), self.least)
        shares = (Parameter(phase, "1", 0.0, -1.0, 1.0) for phase in ("sine", "cosine"))
        return (Parameter("mean", "N·m", 0.0, 0.0, high), *shares)

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The friction loss of each step."""
        joint = models[0].joint(site)
        phases = (values["mean"], values["sine"], values["cosine"])
        return _Uneven(int(joint.qposadr[0]), int(joint.dofadr[0]), *phases)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Little friction, largest at several places."""
        mean = self.start_mean * parameters[0].high
        return tuple({"mean": mean, "sine": sine, "cosine": cosine} for sine, cosine in self.start_shares)


@dataclass(frozen=True)
class _Uneven(Law):
    """Friction loss over the turn of a hinge; mean, sine and cosine of shape (n,)."""

    address: int
    dof: int
    mean: Array
    sine: Array
    cosine: Array

    def act(self, moment: Moment, influence: Influence) -> None:
        angle = moment.qpos[:, self.address]
        share = 1.0 + self.sine * np.sin(angle) + self.cosine * np.cos(angle)
        influence.friction[:, self.dof] += self.mean * np.maximum(share, 0.0)
