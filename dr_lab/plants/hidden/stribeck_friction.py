"""Dry friction that is larger at rest than in motion."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.errors import ConfigError
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect


@dataclass(frozen=True)
class StribeckFriction(HiddenEffect):
    """τ = −sign(q') (coulomb + (static − coulomb) exp(−(q'/speed)²)) while sliding; up to `static` while held.

    Source of the form: Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2.

    Attributes:
        site: joint.
        coulomb: N·m.
        static: N·m, ≥ coulomb.
        speed: Stribeck speed in rad/s, > 0.

    Raises:
        ConfigError: static < coulomb or speed ≤ 0.
    """

    name: ClassVar[str] = "stribeck_friction"
    site: str
    coulomb: NotNegative
    static: NotNegative
    speed: Positive

    def __post_init__(self) -> None:
        if self.static < self.coulomb or self.speed <= 0:
            given = f"static {self.static}, coulomb {self.coulomb} N·m, speed {self.speed} rad/s"
            raise ConfigError(f"Stribeck friction: {given}; expected static ≥ coulomb and speed > 0.")

    def frictions(self) -> tuple[DryFriction, ...]:
        """Friction that falls from static to Coulomb as the joint speeds up."""
        return (DryFriction(self.site, self.coulomb, self.static, self.speed),)
