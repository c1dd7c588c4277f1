"""A pulsed motor that coasts between the pulses, so that its command brakes it, too."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class CoastingBridge(RigidEffect):
    """The drive's force F loses |F| q'/free.

    Attributes:
        joint: that the motor drives alone.
        free: no-load speed, rad/s or m/s.
        site: the actuator.
    """

    name: ClassVar[str] = "coasting_bridge"
    joint: str
    free: float
    site: str = "motor"

    def alter(self, machine: Machine) -> Machine:
        """The machine with that motor."""
        return self.described(machine).with_gear_law(self.joint, self._added)

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        del outside
        return -abs(drive) * velocity / self.free
