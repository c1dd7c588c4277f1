"""A medium that machines do not reckon with."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class AirDrag(RigidEffect):
    """Every link is dragged by a medium that is denser than documented.

    Attributes:
        density: above the documented one, kg/m³.
        site: what lies in it.
    """

    name: ClassVar[str] = "air_drag"
    density: float
    site: str = "world"

    def alter(self, machine: Machine) -> Machine:
        """The machine in the medium."""
        return self.described(machine).with_medium(self.density, (0.0, 0.0, 0.0))
