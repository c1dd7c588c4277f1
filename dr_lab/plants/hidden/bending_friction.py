"""Dry friction as bristles that bend before they slip, the same at every speed."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import Bristle


@dataclass(frozen=True)
class BendingFriction(HiddenEffect):
    """τ = −(stiffness z + damping z'), z' = v − stiffness |v| z / torque: LuGre friction without a Stribeck drop.

    Attributes:
        site: joint.
        torque: N·m or N.
        stiffness: N·m/rad or N/m.
        damping: N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "presliding_friction"
    site: str
    torque: Positive
    stiffness: Positive
    damping: NotNegative

    def memories(self) -> tuple[Bristle, ...]:
        """How far the bristles are bent."""
        return (Bristle(self.site, self._rate, self._force),)

    def _rate(self, bent: float, velocity: float) -> float:
        return velocity - self.stiffness * abs(velocity) * bent / self.torque

    def _force(self, bent: float, rate: float, velocity: float) -> float:
        del velocity
        return -(self.stiffness * bent + self.damping * rate)
