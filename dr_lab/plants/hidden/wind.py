"""A medium that moves."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class Wind(RigidEffect):
    """The documented medium moves past the machine with the level velocity (along_x, along_y).

    Attributes:
        along_x: m/s.
        along_y: m/s.
        site: what lies in it.
    """

    name: ClassVar[str] = "wind"
    along_x: float = 0.0
    along_y: float = 0.0
    site: str = "world"

    def alter(self, machine: Machine) -> Machine:
        """The machine in the wind."""
        return self.described(machine).with_medium(0.0, (self.along_x, self.along_y, 0.0))
