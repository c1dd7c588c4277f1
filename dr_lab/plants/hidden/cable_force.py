"""A cable, hose or tether between the world and a body."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.plants.cable import Cable
from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class CableForce(RigidEffect):
    """It pulls the body's centre of mass towards its anchor, its stretch times its stiffness; shorter, it is slack.

    Attributes:
        site: body.
        anchor: where it is fixed in the world, m.
        length: m.
        stiffness: N/m.
    """

    name: ClassVar[str] = "cable_force"
    site: str
    anchor: Sequence[float]
    length: float
    stiffness: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with the cable."""
        anchor = np.asarray(self.anchor, np.float64)
        return self.described(machine).with_cable(Cable(self.site, anchor, self.length, self.stiffness))
