"""A drive that delivers another torque than its data sheet says."""

from dataclasses import dataclass, replace
from typing import ClassVar

from dr_lab.plants.furuta import Furuta
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class TorqueScale(HiddenEffect):
    """torque = gain · k (u − k q') / R: voltage and back-EMF act with the same share.

    Attributes:
        gain: share of the documented torque.
        site: the actuator.
    """

    name: ClassVar[str] = "torque_scale"
    gain: float
    site: str = "motor"

    def alter(self, machine: Furuta) -> Furuta:
        """The machine with the weaker (or stronger) drive."""
        return replace(machine, motor=replace(machine.motor, gain=machine.motor.gain * self.gain))
