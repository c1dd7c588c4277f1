"""A thruster, whose force grows with the square of its command; the catalogue does not know it."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class SquaredCommand(HiddenEffect):
    """u = command |command| / full: right at `full`, too little below.

    Attributes:
        full: in the command's unit.
        site: the actuator.
    """

    name: ClassVar[str] = "squared_command"
    full: float
    site: str = "motor"

    def command(self, actuator: str, command: Command) -> Command:
        """The thrust."""
        if actuator != self.site:
            return command
        return replace(command, value=command.value * np.abs(command.value) / self.full)
