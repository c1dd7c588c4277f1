"""A controlled drive whose force ends at a limit."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.drive_law import DriveLaw


@dataclass(frozen=True)
class ForceLimit(DriveLaw):
    """The drive's force stays within ±limit.

    Attributes:
        limit: N·m or N.
    """

    name: ClassVar[str] = "force_limit"
    limit: Positive

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        del outside, velocity
        return min(max(drive, -self.limit), self.limit) - drive
