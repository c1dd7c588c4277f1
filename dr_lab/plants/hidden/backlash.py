"""Play in a gear."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect, Motor
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class Backlash(HiddenEffect):
    """The motor, a part of the joint's documented inertia, drives its link through teeth that part within a gap.

    Teeth in contact are a spring and a damper; they push and never pull.

    Attributes:
        site: joint.
        rotor: inertia of the motor seen at the joint, kg·m² or kg.
        gap: way of the motor from one flank to the other, rad or m.
        stiffness: of teeth in contact, N·m/rad or N/m.
        damping: of teeth in contact, N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "backlash"
    site: str
    rotor: float
    gap: float
    stiffness: float
    damping: float

    def alter(self, machine: Machine) -> Machine:
        """The link without the motor."""
        return machine.with_armature(self.site, -self.rotor)

    def motors(self) -> tuple[Motor, ...]:
        """The motor between the flanks."""
        return (Motor(self.site, self.rotor, self._pull),)

    def _pull(self, ahead: float, faster: float) -> float:
        if abs(ahead) <= self.gap / 2:
            return 0.0
        side = 1.0 if ahead > 0 else -1.0
        pressed = self.stiffness * (side * ahead - self.gap / 2) + self.damping * side * faster
        return side * max(pressed, 0.0)
