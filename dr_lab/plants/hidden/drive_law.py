"""What effects of a drive's force have in common."""

from abc import abstractmethod
from dataclasses import dataclass, field

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class DriveLaw(RigidEffect):
    """A force is added to that of a drive.

    Attributes:
        joint: that the drive moves alone.
        site: the actuator.
    """

    joint: str
    site: str = field(default="motor", kw_only=True)

    def alter(self, machine: Machine) -> Machine:
        """The machine with that drive."""
        return self.described(machine).with_gear_law(self.joint, self._added)

    @abstractmethod
    def _added(self, drive: float, outside: float, velocity: float) -> float:
        """What is added to the drive's force, where so much acts from outside and the joint moves so fast."""
