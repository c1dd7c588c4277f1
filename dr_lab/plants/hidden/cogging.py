"""A motor whose torque depends on where its rotor stands."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class Cogging(JointForce):
    """τ = sine · sin(periods · q) + cosine · cos(periods · q).

    Attributes:
        site: joint.
        sine: N·m or N.
        cosine: N·m or N.
        periods: in a turn of the joint; of a slide 2π over the pitch, rad/m.
    """

    name: ClassVar[str] = "cogging"
    site: str
    sine: float
    cosine: float
    periods: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Ripple at the joint."""
        del time, velocity
        turn = self.periods * position
        return self.sine * math.sin(turn) + self.cosine * math.cos(turn)
