"""A bearing whose grease is stiff and whose seal sticks at first, and less and less as it warms."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class Warming(JointForce):
    """τ = −exp(−t / constant) (cold q' + seal tanh(q' / creep)), t in the log: each begins cold.

    Attributes:
        site: joint.
        cold: coefficient of the grease at the beginning in N·m·s/rad or N·s/m.
        constant: time constant in s.
        seal: dry friction at the beginning in N·m or N.
        creep: rad/s or m/s, far below the speeds of the machine.
    """

    name: ClassVar[str] = "friction_drift"
    site: str
    cold: float
    constant: Positive
    seal: float = 0.0
    creep: Positive = 0.01

    def force(self, time: float, position: float, velocity: float) -> float:
        """Friction at the joint."""
        del position
        full = self.cold * velocity + self.seal * math.tanh(velocity / self.creep)
        return -math.exp(-time / self.constant) * full
