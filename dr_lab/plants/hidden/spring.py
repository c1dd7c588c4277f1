"""A spring, such as the pull of a cable."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class Spring(JointForce):
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

    def force(self, time: float, position: float, velocity: float) -> float:
        """Pull at the joint."""
        del time, velocity
        return -self.stiffness * (position - self.rest)
