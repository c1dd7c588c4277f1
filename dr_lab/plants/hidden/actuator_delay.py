"""A motor driver that acts late."""

from dataclasses import dataclass, replace
from typing import ClassVar

from dr_lab.bounds import NotNegative
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class ActuatorDelay(HiddenEffect):
    """u(t) = command(t − delay).

    Attributes:
        delay: s.
        site: the actuator.
    """

    name: ClassVar[str] = "actuator_delay"
    delay: NotNegative
    site: str = "motor"

    def command(self, actuator: str, command: Command) -> Command:
        """The command, later."""
        return replace(command, edge=command.edge + self.delay) if actuator == self.site else command
