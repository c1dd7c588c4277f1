"""A magnet beside the path of a link, which the catalogue does not know."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class Magnet(JointForce):
    """Potential −depth exp(−x²/2) with x = (q − place) / reach, hence τ = −(depth / reach) x exp(−x²/2).

    Attributes:
        site: joint.
        depth: energy that a link caught in the middle of the magnet lacks to leave it, J.
        place: joint position in front of the magnet, rad or m.
        reach: rad or m; the pull is strongest that far from the place.
    """

    name: ClassVar[str] = "magnet"
    site: str
    depth: float
    place: float
    reach: Positive

    def force(self, time: float, position: float, velocity: float) -> float:
        """Pull at the joint."""
        del time, velocity
        away = (position - self.place) / self.reach
        return -self.depth / self.reach * away * math.exp(-0.5 * away * away)
