"""A link that is longer or shorter than documented."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class LinkLength(RigidEffect):
    """The next body begins farther out from the axis; where the link's own mass lies stays.

    Attributes:
        site: the body that begins there.
        excess: m.
    """

    name: ClassVar[str] = "link_length"
    site: str
    excess: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with that link."""
        return self.described(machine).with_link_longer(self.site, self.excess)
