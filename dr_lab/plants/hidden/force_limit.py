"""A controlled drive whose force ends at a limit."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class ForceLimit(RigidEffect):
    """The drive's force stays within ±limit.

    Attributes:
        joint: that the servo drives alone.
        limit: N·m or N.
        site: the actuator.
    """

    name: ClassVar[str] = "force_limit"
    joint: str
    limit: float
    site: str = "motor"

    def alter(self, machine: Machine) -> Machine:
        """The machine with that servo."""
        return self.described(machine).with_gear_law(self.joint, self._added)

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        del outside, velocity
        return min(max(drive, -self.limit), self.limit) - drive
