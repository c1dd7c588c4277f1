"""Something that a joint runs into."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class EndStop(JointForce):
    """Beyond `lower` and `upper`: a bumper that pushes back with stiffness · depth (1 + loss · speed inwards).

    Source of the form: Hunt and Crossley, Journal of Applied Mechanics 42 (1975), with a linear spring.

    Attributes:
        site: joint.
        lower: rad or m.
        upper: rad or m.
        stiffness: N·m/rad or N/m.
        loss: s/rad or s/m.
    """

    name: ClassVar[str] = "end_stop"
    site: str
    lower: float
    upper: float
    stiffness: float
    loss: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """Push of the bumper."""
        del time
        side = 1.0 if position > self.upper else -1.0
        depth = max(position - self.upper, self.lower - position)
        if depth <= 0:
            return 0.0
        return -side * max(self.stiffness * depth * (1 + self.loss * side * velocity), 0.0)
