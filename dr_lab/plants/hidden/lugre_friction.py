"""Dry friction as bristles that bend, and slip where they are bent enough."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import Bristle


@dataclass(frozen=True)
class LugreFriction(HiddenEffect):
    """τ = −(σ₀ z + σ₁ z'), z' = v − σ₀ |v| z / g(v), g(v) = coulomb + (static − coulomb) exp(−(v / speed)²).

    While it slides steadily it is Stribeck's friction, τ = −sign(v) g(v). Source: Canudas de Wit, Olsson, Åström and
    Lischinsky, IEEE Transactions on Automatic Control 40 (1995), equations 1 to 3, without viscous part.

    Attributes:
        site: joint.
        coulomb: N·m or N.
        static: N·m or N, ≥ coulomb.
        speed: Stribeck speed in rad/s or m/s.
        stiffness: σ₀ in N·m/rad or N/m.
        damping: σ₁ in N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "lugre_friction"
    site: str
    coulomb: NotNegative
    static: Positive
    speed: Positive
    stiffness: Positive
    damping: NotNegative

    def memories(self) -> tuple[Bristle, ...]:
        """How far the bristles are bent."""
        return (Bristle(self.site, self._rate, self._force),)

    def _rate(self, bent: float, velocity: float) -> float:
        steady = self.coulomb + (self.static - self.coulomb) * math.exp(-((velocity / self.speed) ** 2))
        return velocity - self.stiffness * abs(velocity) * bent / steady

    def _force(self, bent: float, rate: float, velocity: float) -> float:
        del velocity
        return -(self.stiffness * bent + self.damping * rate)
