"""A spring whose stiffness grows with its displacement."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class HardeningSpring(JointForce):
    """τ = −cubic · q³.

    Attributes:
        site: joint.
        cubic: N·m/rad³ or N/m³.
    """

    name: ClassVar[str] = "hardening_spring"
    site: str
    cubic: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Pull at the joint."""
        del time, velocity
        return -self.cubic * position**3
