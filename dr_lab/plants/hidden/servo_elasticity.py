"""A shaft that twists between the motor of a position controller, whose encoder closes the loop, and its link."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.joint_elasticity import JointElasticity


@dataclass(frozen=True)
class ServoElasticity(JointElasticity):
    """As `JointElasticity`, at a joint that a position controller moves; there every hidden motor has the feedback."""

    name: ClassVar[str] = "servo_elasticity"
