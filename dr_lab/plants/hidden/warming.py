"""A bearing whose grease is stiff at first and thins as it warms, which the catalogue does not know."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class Warming(JointForce):
    """τ = −cold · exp(−t / constant) · q', t in the log: each begins cold.

    Attributes:
        site: joint.
        cold: coefficient at the beginning in N·m·s/rad or N·s/m.
        constant: time constant in s.
    """

    name: ClassVar[str] = "warming"
    site: str
    cold: float
    constant: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Friction at the joint."""
        del position
        return -self.cold * math.exp(-time / self.constant) * velocity
