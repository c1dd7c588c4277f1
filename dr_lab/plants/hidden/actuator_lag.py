"""A motor driver that acts gradually."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.memory import SlowCommand


@dataclass(frozen=True)
class ActuatorLag(HiddenEffect):
    """constant · x' = u − x, and x acts.

    Attributes:
        constant: s.
        site: the actuator.
    """

    name: ClassVar[str] = "actuator_lag"
    constant: Positive
    site: str = "motor"

    def memories(self) -> tuple[SlowCommand, ...]:
        """What acts."""
        return (SlowCommand(self.site, self._rate),)

    def _rate(self, acting: float, command: float) -> float:
        return (command - acting) / self.constant
