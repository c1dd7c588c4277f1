"""A constant torque, such as an amplifier's offset."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.furuta import Pair
from dr_lab.plants.hidden.effect import HiddenEffect, at_joint


@dataclass(frozen=True)
class ConstantOffset(HiddenEffect):
    """τ = torque, whatever the state.

    Attributes:
        site: joint.
        torque: N·m.
    """

    name: ClassVar[str] = "constant_offset"
    site: str
    torque: float

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """The torque at the joint."""
        del position, velocity
        return at_joint(self.site, self.torque)
