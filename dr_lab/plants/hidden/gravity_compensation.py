"""A controller that carries the weight of its robot."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class GravityCompensation(HiddenEffect):
    """The controller adds `share` of the torques that hold the links, which is as if gravity were smaller.

    Attributes:
        share: 1.
        site: what is carried.
    """

    name: ClassVar[str] = "gravity_compensation"
    share: float
    site: str = "world"

    def alter(self, machine: Machine) -> Machine:
        """The machine in less gravity."""
        x, y, z = ((1.0 - self.share) * g for g in machine.gravity)
        return machine.with_gravity((x, y, z))
