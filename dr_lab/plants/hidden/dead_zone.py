"""A driver that does not answer to small commands."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dr_lab.bounds import NotNegative
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class DeadZone(HiddenEffect):
    """u = sign(command) · max(|command| − width, 0).

    Attributes:
        width: in the command's unit.
        site: the actuator.
    """

    name: ClassVar[str] = "dead_zone"
    width: NotNegative
    site: str = "motor"

    def command(self, actuator: str, command: Command) -> Command:
        """The command, less the width."""
        if actuator != self.site:
            return command
        size = np.maximum(np.abs(command.value) - self.width, 0.0)
        return replace(command, value=np.sign(command.value) * size)
