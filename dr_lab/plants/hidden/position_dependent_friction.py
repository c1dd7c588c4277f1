"""Dry friction that depends on where in its turn a joint stands."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class PositionDependentFriction(JointForce):
    """τ = −mean (1 + sine sin q + cosine cos q) tanh(q' / creep).

    Attributes:
        site: joint.
        mean: N·m.
        sine: share of the mean.
        cosine: share of the mean.
        creep: rad/s, far below the speeds of the machine.
    """

    name: ClassVar[str] = "position_dependent_friction"
    site: str
    mean: float
    sine: float
    cosine: float
    creep: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Friction at the joint."""
        del time
        here = 1 + self.sine * math.sin(position) + self.cosine * math.cos(position)
        return -self.mean * here * math.tanh(velocity / self.creep)
