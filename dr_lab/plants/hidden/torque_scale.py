"""A drive that delivers another torque than its data sheet says."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class TorqueScale(HiddenEffect):
    """Force = gain · documented force; of a motor voltage and back-EMF act with the same share.

    Attributes:
        gain: share of the documented force.
        site: the actuator.
    """

    name: ClassVar[str] = "torque_scale"
    gain: float
    site: str = "motor"

    def alter(self, machine: Machine) -> Machine:
        """The machine with the weaker (or stronger) drive."""
        return machine.with_drive_scaled(self.site, self.gain)
