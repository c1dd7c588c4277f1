"""Inertia of a rotor behind a joint."""

from dataclasses import dataclass, replace
from typing import ClassVar

from dr_lab.plants.furuta import Furuta
from dr_lab.plants.hidden.effect import HiddenEffect, at_joint


@dataclass(frozen=True)
class Armature(HiddenEffect):
    """Adds ½ inertia q'² to the kinetic energy.

    Attributes:
        site: joint.
        inertia: kg·m².
    """

    name: ClassVar[str] = "armature"
    site: str
    inertia: float

    def alter(self, machine: Furuta) -> Furuta:
        """The machine with the rotor."""
        arm, pole = at_joint(self.site, self.inertia)
        return replace(machine, armature=(machine.armature[0] + arm, machine.armature[1] + pole))
