"""A rigid body of any shape that is fixed to a link."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class RigidPayload(RigidEffect):
    """Point masses that are held together by rods without mass; four that lie in no plane can be any rigid body.

    Attributes:
        site: the body.
        masses: kg, of each point.
        places: m, three numbers in the body's frame for each point.
    """

    name: ClassVar[str] = "rigid_payload"
    site: str
    masses: Sequence[float]
    places: Sequence[Sequence[float]]

    def alter(self, machine: Machine) -> Machine:
        """The machine with the points."""
        found = self.described(machine)
        for mass, place in zip(self.masses, self.places, strict=True):
            found = found.with_mass_at(self.site, mass, np.asarray(place, dtype=np.float64))
        return found
