"""A motor that does not move with its link: what drives the link is how far the one is ahead of the other."""

from abc import abstractmethod
from dataclasses import dataclass

from dr_lab.plants.hidden.effect import HiddenEffect, Motor
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class MotorApart(HiddenEffect):
    """The motor, a part of the joint's documented inertia, is a body of its own.

    Attributes:
        site: joint.
        rotor: inertia of the motor seen at the joint, kg·m² or kg.
    """

    site: str
    rotor: float

    def alter(self, machine: Machine) -> Machine:
        """The link without the motor."""
        return machine.with_armature(self.site, -self.rotor)

    def motors(self) -> tuple[Motor, ...]:
        """The motor."""
        return (Motor(self.site, self.rotor, self.pull),)

    @abstractmethod
    def pull(self, ahead: float, faster: float) -> float:
        """Force on the link, N·m or N, of a motor that is ahead by rad or m and faster by rad/s or m/s."""
