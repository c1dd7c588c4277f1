"""Dry friction of constant size."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class CoulombFriction(HiddenEffect):
    """τ = −sign(q') torque while sliding; up to `torque` while held.

    Attributes:
        site: joint.
        torque: N·m, or N at a slide.
    """

    name: ClassVar[str] = "coulomb_friction"
    site: str
    torque: NotNegative

    def frictions(self) -> tuple[DryFriction, ...]:
        """The same friction at rest and at any speed."""
        return (DryFriction(self.site, self.torque, self.torque),)
