"""An encoder disc that is off its centre."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class EncoderEccentricity(HiddenEffect):
    """reading = q + sine sin q + cosine cos q.

    Attributes:
        site: the joint whose disc is off.
        sine: rad.
        cosine: rad.
    """

    name: ClassVar[str] = "encoder_eccentricity"
    site: str
    sine: float
    cosine: float

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """The disc's angle."""
        del time
        return position + (joint == self.site) * (self.sine * np.sin(position) + self.cosine * np.cos(position))
