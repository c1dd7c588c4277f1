"""Inertia of a rotor behind a joint."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class Armature(HiddenEffect):
    """Adds ½ inertia q'² to the kinetic energy.

    Attributes:
        site: joint.
        inertia: kg·m² or kg.
    """

    name: ClassVar[str] = "armature"
    site: str
    inertia: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with the rotor."""
        return machine.with_armature(self.site, self.inertia)
