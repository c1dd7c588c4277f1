"""Dry friction that is larger in one direction than in the other."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class AsymmetricFriction(HiddenEffect):
    """τ = −sign(q') mean (1 + asymmetry sign(q')) while sliding; up to as much while held.

    Attributes:
        site: joint.
        mean: of the two directions, N·m, or N at a slide.
        asymmetry: share by which friction is larger forward and smaller backward, within ±1.
    """

    name: ClassVar[str] = "asymmetric_friction"
    site: str
    mean: float
    asymmetry: float

    def frictions(self) -> tuple[DryFriction, ...]:
        """Friction that depends on the direction alone."""
        return (DryFriction(self.site, self.mean, self.mean, asymmetry=self.asymmetry),)
