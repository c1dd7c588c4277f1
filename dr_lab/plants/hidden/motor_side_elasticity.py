"""A shaft that twists between motor and link, seen from the motor."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.joint_elasticity import JointElasticity


@dataclass(frozen=True)
class MotorSideElasticity(JointElasticity):
    """As `JointElasticity`, where the encoder sits on the motor."""

    name: ClassVar[str] = "motor_side_elasticity"

    def read_at_motor(self, joint: str) -> bool:
        """At the elastic joint."""
        return joint == self.site
