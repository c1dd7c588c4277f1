"""An encoder that counts too much or too little."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class SensorScale(HiddenEffect):
    """reading = (1 + excess) q.

    Attributes:
        site: the joint whose encoder miscounts.
        excess: 1.
    """

    name: ClassVar[str] = "sensor_scale"
    site: str
    excess: float

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """The wrong count."""
        del time
        return position * (1 + self.excess) if joint == self.site else position
