"""Ground with another grip."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.contact_effect import HiddenContactEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class ContactFriction(HiddenContactEffect):
    """|f_t| ≤ factor · μ f_n.

    Attributes:
        site: body that touches the ground.
        factor: share of the documented sliding friction.
    """

    name: ClassVar[str] = "contact_friction"
    site: str
    factor: float

    def alter(self, machine: Machine) -> Machine:
        """The machine on that ground."""
        return self.touching(machine).with_contact(self.factor, 1.0, 1.0)
