"""More viscous friction than the machine's documents say."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class ViscousFriction(JointForce):
    """τ = −coefficient · q', beside the machine's own damping.

    Attributes:
        site: joint.
        coefficient: N·m·s/rad.
    """

    name: ClassVar[str] = "viscous_friction"
    site: str
    coefficient: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Friction at the joint."""
        del time, position
        return -self.coefficient * velocity
