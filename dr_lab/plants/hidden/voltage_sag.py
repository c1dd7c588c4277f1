"""A supply that gives way under load."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class VoltageSag(HiddenEffect):
    """u = command (1 − slope |command|).

    Attributes:
        slope: 1 / unit of the command.
        site: the actuator.
    """

    name: ClassVar[str] = "voltage_sag"
    slope: float
    site: str = "motor"

    def command(self, actuator: str, command: Command) -> Command:
        """The command, less what the supply loses."""
        if actuator != self.site:
            return command
        return replace(command, value=command.value * (1 - self.slope * np.abs(command.value)))
