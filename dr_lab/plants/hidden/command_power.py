"""A thruster or a valve, whose force grows with a power of its command."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dr_lab.bounds import Positive
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class CommandPower(HiddenEffect):
    """u = sign(command) full (|command| / full)^exponent: right at `full`.

    Attributes:
        full: in the command's unit.
        exponent: 2 for a propeller.
        site: the actuator.
    """

    name: ClassVar[str] = "command_power"
    full: Positive
    exponent: Positive = 2.0
    site: str = "motor"

    def command(self, actuator: str, command: Command) -> Command:
        """The thrust."""
        if actuator != self.site:
            return command
        thrust = np.sign(command.value) * self.full * (np.abs(command.value) / self.full) ** self.exponent
        return replace(command, value=thrust)
