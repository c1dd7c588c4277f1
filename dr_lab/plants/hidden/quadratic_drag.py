"""Drag that grows with the square of the speed."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.furuta import Pair
from dr_lab.plants.hidden.effect import HiddenEffect, at_joint, joint_index


@dataclass(frozen=True)
class QuadraticDrag(HiddenEffect):
    """τ = −coefficient · q' |q'|.

    Attributes:
        site: joint.
        coefficient: N·m·s²/rad².
    """

    name: ClassVar[str] = "quadratic_drag"
    site: str
    coefficient: float

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """Drag at the joint."""
        del position
        speed = velocity[joint_index(self.site)]
        return at_joint(self.site, -self.coefficient * speed * abs(speed))
