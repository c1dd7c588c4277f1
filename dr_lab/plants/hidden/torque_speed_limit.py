"""A motor whose largest torque falls with its speed."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import Positive
from dr_lab.plants.hidden.drive_law import DriveLaw


@dataclass(frozen=True)
class TorqueSpeedLimit(DriveLaw):
    """The drive's force F stays within −stall (1 + q'/free) ≤ F ≤ stall (1 − q'/free).

    Attributes:
        stall: N·m or N.
        free: rad/s or m/s.
    """

    name: ClassVar[str] = "torque_speed_limit"
    stall: Positive
    free: Positive

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        del outside
        share = velocity / self.free
        return min(max(drive, -self.stall * (1 + share)), self.stall * (1 - share)) - drive
