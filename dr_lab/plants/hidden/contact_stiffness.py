"""Ground that gives way and throws back otherwise."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.contact_effect import HiddenContactEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class ContactStiffness(HiddenContactEffect):
    """A penetration r that obeys r'' + 2 r'/T + r/(T ζ)² = 0, as MuJoCo's contacts do, with another T and ζ.

    Attributes:
        site: body that touches the ground.
        time_constant: share of the documented T.
        damping_ratio: share of the documented ζ.
    """

    name: ClassVar[str] = "contact_stiffness"
    site: str
    time_constant: float
    damping_ratio: float

    def alter(self, machine: Machine) -> Machine:
        """The machine on that ground."""
        return self.touching(machine).with_contact(1.0, self.time_constant, self.damping_ratio)
