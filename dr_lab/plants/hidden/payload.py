"""A mass somebody attached."""

from dataclasses import dataclass, replace
from typing import ClassVar

from dr_lab.plants.furuta import Furuta, Moments
from dr_lab.plants.hidden.effect import HiddenEffect, joint_index


@dataclass(frozen=True)
class Payload(HiddenEffect):
    """A point mass on a link's own line.

    Attributes:
        site: the link, by its joint's name.
        mass: kg.
        distance: m from the link's joint.
    """

    name: ClassVar[str] = "payload"
    site: str
    mass: float
    distance: float

    def alter(self, machine: Furuta) -> Furuta:
        """The machine with the mass."""
        load = Moments.point(self.mass, self.distance)
        if joint_index(self.site) == 0:
            return replace(machine, arm=machine.arm + load)
        return replace(machine, pole=machine.pole + load)
