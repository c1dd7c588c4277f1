"""A base that does not stand level."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class BaseTilt(HiddenEffect):
    """The base is turned by the horizontal vector a e = (about_x, about_y, 0).

    In its frame gravity g is turned the other way (Rodrigues): g cos a − (e × g) sin a + e (e · g)(1 − cos a).

    Attributes:
        about_x: rad.
        about_y: rad.
        site: what is tilted.
    """

    name: ClassVar[str] = "base_tilt"
    about_x: float = 0.0
    about_y: float = 0.0
    site: str = "world"

    def alter(self, machine: Machine) -> Machine:
        """The machine in tilted gravity."""
        x, y, z = machine.gravity
        angle = math.hypot(self.about_x, self.about_y)
        along_x, along_y = (self.about_x / angle, self.about_y / angle) if angle else (1.0, 0.0)
        sine, cosine = math.sin(angle), math.cos(angle)
        kept = (along_x * x + along_y * y) * (1 - cosine)
        return machine.with_gravity(
            (
                x * cosine - along_y * z * sine + along_x * kept,
                y * cosine + along_x * z * sine + along_y * kept,
                z * cosine - (along_x * y - along_y * x) * sine,
            )
        )
