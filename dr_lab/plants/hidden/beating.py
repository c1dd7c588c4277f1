"""A machine nearby that shakes a joint at a frequency of its own, which the catalogue does not know."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class Beating(JointForce):
    """τ = amplitude · sin(2π frequency t), t in the log.

    Attributes:
        site: joint.
        amplitude: N·m or N.
        frequency: Hz.
    """

    name: ClassVar[str] = "beating"
    site: str
    amplitude: float
    frequency: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Shaking at the joint."""
        del position, velocity
        return self.amplitude * math.sin(2 * math.pi * self.frequency * time)
