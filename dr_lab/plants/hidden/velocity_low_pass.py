"""A filter between a tachometer and its log."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import SlowVelocity


@dataclass(frozen=True)
class VelocityLowPass(HiddenEffect):
    """constant · reading' = q' − reading, of the velocity alone; instruments that measure none do not show it.

    Attributes:
        site: the joint whose tachometer is filtered.
        constant: s.
    """

    name: ClassVar[str] = "velocity_low_pass"
    site: str
    constant: Positive

    def memories(self) -> tuple[SlowVelocity, ...]:
        """What is shown."""
        return (SlowVelocity(self.site, self.constant),)
