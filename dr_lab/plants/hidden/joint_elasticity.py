"""A shaft that twists between motor and link."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.plants.hidden.motor_apart import MotorApart


@dataclass(frozen=True)
class JointElasticity(MotorApart):
    """The motor drives its link through a spring and a damper.

    Attributes:
        compliance: of the spring, rad/(N·m) or m/N.
        damping: N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "joint_elasticity"
    compliance: Positive
    damping: NotNegative

    def pull(self, ahead: float, faster: float) -> float:
        """Of spring and damper."""
        return ahead / self.compliance + self.damping * faster
