"""A motor driver that cannot give more than so many volts."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class Saturation(HiddenEffect):
    """u = command clipped to ± limit.

    Attributes:
        limit: V.
        site: the actuator.
    """

    name: ClassVar[str] = "saturation"
    limit: float
    site: str = "motor"

    def command(self, command: Command) -> Command:
        """The command, clipped."""
        return replace(command, value=np.clip(command.value, -self.limit, self.limit))
