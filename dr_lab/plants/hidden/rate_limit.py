"""A motor driver that changes what it gives at a limited rate."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import SlowCommand


@dataclass(frozen=True)
class RateLimit(HiddenEffect):
    """x' = (u − x) / settling within ± rate, and x acts: a ramp that rounds off where it arrives.

    Attributes:
        rate: largest, in the command's unit per s.
        settling: time constant of the arrival, s, far below the time between commands.
        site: the actuator.
    """

    name: ClassVar[str] = "rate_limit"
    rate: Positive
    settling: Positive
    site: str = "motor"

    def memories(self) -> tuple[SlowCommand, ...]:
        """What acts."""
        return (SlowCommand(self.site, self._rate),)

    def _rate(self, acting: float, command: float) -> float:
        return min(max((command - acting) / self.settling, -self.rate), self.rate)
