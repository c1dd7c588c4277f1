"""A driver that cannot give more than so much."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dr_lab.bounds import Positive
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class Saturation(HiddenEffect):
    """u = command clipped to ± limit.

    Attributes:
        limit: in the command's unit.
        site: the actuator.
    """

    name: ClassVar[str] = "saturation"
    limit: Positive
    site: str = "motor"

    def command(self, actuator: str, command: Command) -> Command:
        """The command, clipped."""
        if actuator != self.site:
            return command
        return replace(command, value=np.clip(command.value, -self.limit, self.limit))
