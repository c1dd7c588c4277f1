"""Drag that grows with the square of the speed."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class QuadraticDrag(JointForce):
    """τ = −coefficient · q' |q'|.

    Attributes:
        site: joint.
        coefficient: N·m·s²/rad².
    """

    name: ClassVar[str] = "quadratic_drag"
    site: str
    coefficient: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Drag at the joint."""
        del time, position
        return -self.coefficient * velocity * abs(velocity)
