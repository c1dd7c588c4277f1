"""An encoder whose value is older than its stamp."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class SensorTimeOffset(HiddenEffect):
    """reading(t) = q(t − delay).

    Attributes:
        site: the joint whose encoder is late.
        delay: s.
    """

    name: ClassVar[str] = "sensor_time_offset"
    site: str
    delay: float

    def reading_delay(self, joint: str) -> float:
        """The delay at the joint."""
        return self.delay if joint == self.site else 0.0
