"""A filter between an encoder and its log."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import SlowReading


@dataclass(frozen=True)
class SensorLowPass(HiddenEffect):
    """constant · reading' = q − reading.

    Attributes:
        site: the joint whose encoder is filtered.
        constant: s.
    """

    name: ClassVar[str] = "sensor_low_pass"
    site: str
    constant: Positive

    def memories(self) -> tuple[SlowReading, ...]:
        """What is shown."""
        return (SlowReading(self.site, self.constant),)
