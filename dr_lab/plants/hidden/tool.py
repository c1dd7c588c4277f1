"""A tool at a flange: a mass anywhere on a body."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class Tool(RigidEffect):
    """A point mass at a place in a body's frame.

    Attributes:
        site: the body.
        mass: kg.
        place: m, three numbers.
    """

    name: ClassVar[str] = "payload"
    site: str
    mass: float
    place: Sequence[float]

    def alter(self, machine: Machine) -> Machine:
        """The machine with the tool."""
        return self.described(machine).with_mass_at(self.site, self.mass, np.asarray(self.place, dtype=np.float64))
