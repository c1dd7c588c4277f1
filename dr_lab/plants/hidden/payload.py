"""A mass somebody attached."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class Payload(HiddenEffect):
    """A point mass on a link's own line.

    Attributes:
        site: the link's body.
        mass: kg.
        distance: m from the link's joint.
    """

    name: ClassVar[str] = "payload"
    site: str
    mass: float
    distance: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with the mass."""
        return machine.with_load(self.site, self.mass, self.distance)
