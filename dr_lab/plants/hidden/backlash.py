"""Play in a gear."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.plants.hidden.motor_apart import MotorApart


@dataclass(frozen=True)
class Backlash(MotorApart):
    """The motor drives its link through teeth that part within a gap.

    Teeth in contact are a spring and a damper; they push and never pull.

    Attributes:
        gap: way of the motor from one flank to the other, rad or m.
        stiffness: of teeth in contact, N·m/rad or N/m.
        damping: of teeth in contact, N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "backlash"
    gap: NotNegative
    stiffness: Positive
    damping: NotNegative

    def pull(self, ahead: float, faster: float) -> float:
        """Of the flank that the motor presses."""
        if abs(ahead) <= self.gap / 2:
            return 0.0
        side = 1.0 if ahead > 0 else -1.0
        pressed = self.stiffness * (side * ahead - self.gap / 2) + self.damping * side * faster
        return side * max(pressed, 0.0)
