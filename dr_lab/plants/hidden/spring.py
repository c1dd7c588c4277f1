"""A spring, such as the pull of a cable."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.furuta import Pair
from dr_lab.plants.hidden.effect import HiddenEffect, at_joint, joint_index


@dataclass(frozen=True)
class Spring(HiddenEffect):
    """τ = −stiffness · (q − rest).

    Attributes:
        site: joint.
        stiffness: N·m/rad.
        rest: angle without force in rad.
    """

    name: ClassVar[str] = "spring"
    site: str
    stiffness: float
    rest: float = 0.0

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """Pull at the joint."""
        del velocity
        return at_joint(self.site, -self.stiffness * (position[joint_index(self.site)] - self.rest))
