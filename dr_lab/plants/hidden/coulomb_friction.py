"""Dry friction of constant size."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect, joint_index


@dataclass(frozen=True)
class CoulombFriction(HiddenEffect):
    """τ = −sign(q') torque while sliding; up to `torque` while held.

    Attributes:
        site: joint.
        torque: N·m.
    """

    name: ClassVar[str] = "coulomb_friction"
    site: str
    torque: float

    def friction(self) -> DryFriction:
        """The same friction at rest and at any speed."""
        return DryFriction(joint_index(self.site), self.torque, self.torque)
