"""More viscous friction than the machine's documents say."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.furuta import Pair
from dr_lab.plants.hidden.effect import HiddenEffect, at_joint, joint_index


@dataclass(frozen=True)
class ViscousFriction(HiddenEffect):
    """τ = −coefficient · q', beside the machine's own damping.

    Attributes:
        site: joint.
        coefficient: N·m·s/rad.
    """

    name: ClassVar[str] = "viscous_friction"
    site: str
    coefficient: float

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """Friction at the joint."""
        del position
        return at_joint(self.site, -self.coefficient * velocity[joint_index(self.site)])
