"""A link whose mass is spread otherwise."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class InertiaError(RigidEffect):
    """The inertia about the centre is `factor` times the documented one.

    Attributes:
        site: the body.
        factor: 1.
    """

    name: ClassVar[str] = "inertia_error"
    site: str
    factor: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with that inertia."""
        return self.described(machine).with_inertia_scaled(self.site, self.factor)
