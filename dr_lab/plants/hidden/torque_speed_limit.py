"""A motor whose largest torque falls with its speed."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class TorqueSpeedLimit(RigidEffect):
    """The drive's force F stays within −stall (1 + q'/free) ≤ F ≤ stall (1 − q'/free).

    Attributes:
        joint: that the motor drives alone.
        stall: N·m or N.
        free: rad/s or m/s.
        site: the actuator.
    """

    name: ClassVar[str] = "torque_speed_limit"
    joint: str
    stall: float
    free: float
    site: str = "motor"

    def alter(self, machine: Machine) -> Machine:
        """The machine with that motor."""
        return self.described(machine).with_gear_law(self.joint, self._added)

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        del outside
        share = velocity / self.free
        return min(max(drive, -self.stall * (1 + share)), self.stall * (1 - share)) - drive
