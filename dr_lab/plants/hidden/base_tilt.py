"""A base that does not stand level."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from dr_lab.plants.furuta import Furuta
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class BaseTilt(HiddenEffect):
    """The base is turned by `angle` about its +x, so that in its frame gravity is g (0, −sin angle, −cos angle).

    Attributes:
        angle: rad.
        site: the base.
    """

    name: ClassVar[str] = "base_tilt"
    angle: float
    site: str = "base"

    def alter(self, machine: Furuta) -> Furuta:
        """The machine in tilted gravity."""
        x, y, z = machine.gravity
        sine, cosine = math.sin(self.angle), math.cos(self.angle)
        return replace(machine, gravity=(x, y * cosine + z * sine, z * cosine - y * sine))
