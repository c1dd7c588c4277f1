"""A part of a link that swings on its own: a flexible beam, liquid, a loose load, a hanging cable."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect, slides
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.law import Influence, Law, Moment, MotionLaw
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

Complex = NDArray[np.complex128]
_STEPS = 60  # of the simulation, that the shortest period takes at least: ω h is 0.1, and the explicit force stable


@dataclass(frozen=True)
class FlexibleMode(JointEffect, ForceLaw):
    """An unmeasured inertia that a joint's link drags along by a spring and a damper: one mode of what is not rigid.

    With the distance δ of the part before its link and ω = 2π/P: δ'' + 2 ζ ω δ' + ω² δ = −q'', and the link feels
    tau = J (ω² δ + 2 ζ ω δ'), which is −J (q + δ)''. The part has no weight. For P → 0 it is `Armature`.

    Each step is the exact solution for the link's mean velocity; the force is what the part's momentum changes by.
    Before a window's start the part follows the motion that was measured in ``windows.lookback`` seconds, from rest.

    Parameters (nominal = absent): inertia J ≥ 0 [kg·m², slide: kg]; period P > 0 [s] and damping ratio ζ > 0, which act
    only where J > 0 (fits start away from absent).
    Limits: hinge and slide joints; one mode of each; periods of 60 time steps at least, for the force is that of the
    step's extrapolated velocity, which feeds faster modes of heavy parts; what swung before the lookback is forgotten,
    so that a mode with ζ ω below 1 over the lookback begins wrong. Logs are taken to begin at rest: where one begins in
    motion, its first seconds are told wrong.
    Source: the equivalent mechanical model of a sloshing liquid, Abramson (ed.), The Dynamic Behavior of Liquids in
    Moving Containers, NASA SP-106 (1966), chapter 6; of a flexible link with one assumed mode, De Luca and Book,
    Springer Handbook of Robotics (2016), section 11.3.

    Attributes:
        factor: largest J, in units of the inertia that the joint has in the model's initial position.
        periods: smallest, nominal and largest P [s].
        dampings: smallest, nominal and largest ζ.
        start_inertia: J of the fits that start away from absent, share of its upper bound.
        start_periods: P of these fits [s].
    """

    factor: float
    periods: tuple[float, float, float]
    dampings: tuple[float, float, float]
    start_inertia: float
    start_periods: tuple[float, ...]

    name: ClassVar[str] = "flexible_mode"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "tau = J (w^2 delta + 2 zeta w delta'), delta'' + 2 zeta w delta' + w^2 delta = -q''"
    fingerprint: ClassVar[str] = "force residual that rings on at one frequency after the joint was moved or stopped"
    confused_with: ClassVar[tuple[str, ...]] = ("armature", "inertia_error", "joint_elasticity", "payload")
    holds: ClassVar[Mapping[str, SpecialCase]] = {"armature": SpecialCase(("period",), {"inertia": "inertia"})}
    shapes: ClassVar[tuple[str, ...]] = ("period", "damping")
    divisors: ClassVar[tuple[str, ...]] = ("period",)
    limited: ClassVar[tuple[str, ...]] = ("inertia",)
    lacks: ClassVar[str] = "the part that swings on a spring; add a body on a sprung joint for it"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Inertia, period and damping of the part."""
        del scales
        high = self.factor * float(model.dof_M0[model.joint(site).dofadr[0]])
        shortest, period, longest = self.periods
        shortest = max(shortest, _STEPS * float(model.opt.timestep))
        least, damping, most = self.dampings
        return (
            Parameter("inertia", "kg" if slides(model, site) else "kg·m²", 0.0, 0.0, high),
            Parameter("period", "s", max(period, shortest), shortest, max(longest, shortest)),
            Parameter("damping", "1", damping, least, most),
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The part on its spring."""
        dof = int(models[0].joint(site).dofadr[0])
        return _Swinging(dof, values["inertia"], 2 * np.pi / values["period"], values["damping"])

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A small part that swings at several periods."""
        inertia, period, _ = parameters
        small = self.start_inertia * inertia.high
        return tuple({"inertia": small, "period": at} for at in self.start_periods if period.low <= at <= period.high)


@dataclass
class _Swinging(MotionLaw):
    """The part, told by a = δ' + (ζ ω + i ω_d) δ, which turns by exp((−ζ ω + i ω_d) t) where the link moves evenly.

    Where the link's velocity rises by Δv, a falls by Δv. Inertia, ω and ζ of shape (n,) or (1,).

    Attributes:
        swing: a of each simulation, shape (n,).
        speed: velocity of the link in the step before, NaN where there was none, shape (n,).
    """

    dof: int
    inertia: Array
    frequency: Array
    damping: Array
    swing: Complex = field(default_factory=lambda: np.zeros(1, complex))
    speed: Array = field(default_factory=lambda: np.full(1, np.nan))

    looks_far: ClassVar[bool] = True

    @property
    def _decay(self) -> Array:
        return self.damping * self.frequency

    @property
    def _turn(self) -> Array:
        return self.frequency * np.sqrt(1 - self.damping**2)

    def _of(self, count: int) -> None:
        """Have memory for so many simulations; all are at rest if there were others before."""
        if len(self.swing) != count:
            self.swing, self.speed = np.zeros(count, complex), np.full(count, np.nan)

    def rest(self, rows: NDArray[np.intp]) -> None:
        if len(self.swing) > rows.max(initial=0):
            self.swing[rows], self.speed[rows] = 0.0, np.nan

    @property
    def memory(self) -> Array:
        """Real and imaginary part of a, and the velocity before, shape (n, 3)."""
        return np.stack([self.swing.real, self.swing.imag, self.speed], axis=1)

    def remember(self, memory: Array) -> None:
        self.swing, self.speed = memory[:, 0] + 1j * memory[:, 1], memory[:, 2].copy()

    def follow(self, qvel: Array, step: float) -> None:
        """Go along a motion; where nothing came before it, the part moves with the link at first."""
        count, steps = qvel.shape[:2]
        self._of(count)
        if not steps:
            return
        speed = qvel[:, :, self.dof]
        before = np.where(np.isnan(self.speed), speed[:, 0], self.speed)
        rise = np.diff(speed, axis=1, prepend=before[:, None])
        pole = (-self._decay + 1j * self._turn)[:, None] * step
        ago = np.exp(pole * np.arange(steps, 0, -1))
        self.swing = ago[:, 0] * self.swing - (ago * rise).sum(1)
        self.speed = speed[:, -1].copy()

    def act(self, moment: Moment, influence: Influence) -> None:
        speed = moment.qvel[:, self.dof]
        self._of(len(speed))
        begun = self.swing - np.where(np.isnan(self.speed), 0.0, speed - self.speed)
        ended = np.exp((-self._decay + 1j * self._turn) * moment.step) * begun
        change = (ended - begun).real - self._decay / self._turn * (ended - begun).imag  # of δ', and of q' + δ'
        influence.force[:, self.dof] -= self.inertia * change / moment.step
        self.swing, self.speed = ended, speed.copy()
