"""A shaft that twists between motor and link."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect, Motor
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class JointElasticity(HiddenEffect):
    """The motor, a part of the joint's documented inertia, drives its link through a spring and a damper.

    Attributes:
        site: joint.
        rotor: inertia of the motor seen at the joint, kg·m² or kg.
        compliance: of the spring, rad/(N·m) or m/N.
        damping: N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "joint_elasticity"
    site: str
    rotor: float
    compliance: float
    damping: float

    def alter(self, machine: Machine) -> Machine:
        """The link without the motor."""
        return machine.with_armature(self.site, -self.rotor)

    def motors(self) -> tuple[Motor, ...]:
        """The motor on its spring."""
        return (Motor(self.site, self.rotor, self._pull),)

    def _pull(self, ahead: float, faster: float) -> float:
        return ahead / self.compliance + self.damping * faster
