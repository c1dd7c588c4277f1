"""A link whose centre of mass lies elsewhere."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class CentreOfMassOffset(RigidEffect):
    """The centre is moved in the body's frame; mass and inertia about the centre stay.

    Attributes:
        site: the body.
        offset: m, three numbers.
    """

    name: ClassVar[str] = "centre_of_mass_offset"
    site: str
    offset: Sequence[float]

    def alter(self, machine: Machine) -> Machine:
        """The machine with the centre there."""
        return self.described(machine).with_centre_moved(self.site, np.asarray(self.offset, dtype=np.float64))
