"""A constant torque, such as an amplifier's offset."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class ConstantOffset(JointForce):
    """τ = torque, whatever the state.

    Attributes:
        site: joint.
        torque: N·m.
    """

    name: ClassVar[str] = "constant_offset"
    site: str
    torque: float

    def force(self, time: float, position: float, velocity: float) -> float:
        """The torque at the joint."""
        del time, position, velocity
        return self.torque
