"""An encoder disc that is off its centre, or a screw of uneven lead."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class EncoderEccentricity(HiddenEffect):
    """The disc turns by φ = periods q and shows φ + sine sin φ + cosine cos φ, which is read as the joint's position.

    Attributes:
        site: the joint whose disc is off.
        sine: rad of the disc.
        cosine: rad of the disc.
        periods: in a turn of the joint; of a slide 2π over the lead, rad/m.
    """

    name: ClassVar[str] = "encoder_eccentricity"
    site: str
    sine: float
    cosine: float
    periods: Positive = 1.0

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """The disc's angle."""
        del time
        if joint != self.site:
            return position
        turn = self.periods * position
        return (turn + self.sine * np.sin(turn) + self.cosine * np.cos(turn)) / self.periods
