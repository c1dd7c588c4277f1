"""A position controller whose gain is not the documented one."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class GainError(RigidEffect):
    """The stiffness of the controller is `share` of the documented one; its damping stays.

    Attributes:
        site: the actuator.
        share: 1.
    """

    name: ClassVar[str] = "gain_error"
    site: str
    share: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with that controller."""
        return self.described(machine).with_stiffness_scaled(self.site, self.share)
