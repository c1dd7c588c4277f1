"""A pulsed motor that coasts between the pulses, so that its command brakes it, too."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.drive_law import DriveLaw


@dataclass(frozen=True)
class CoastingBridge(DriveLaw):
    """The drive's force F loses |F| q'/free.

    Attributes:
        free: no-load speed, rad/s or m/s.
    """

    name: ClassVar[str] = "coasting_bridge"
    free: float

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        del outside
        return -abs(drive) * velocity / self.free
