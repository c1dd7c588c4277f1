"""The law of dry friction at one joint: what it can hold, and what it takes from a sliding joint."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class DryFriction:
    """Dry friction that holds a joint up to a limit and brakes it while it slides.

    With share s = 1 + asymmetry · d in the direction d = ±1 in which the joint slides, or would slide:
    while the joint is held |τ| ≤ s · static; while it slides

        |τ|(v) = s · (coulomb + (static − coulomb) exp(−(v / speed)²)).

    A held joint does not creep: sticking is a constraint, left when the force it needs exceeds the limit.

    Attributes:
        joint: name of the joint.
        coulomb: sliding friction at high speed in N·m or N, mean of both directions.
        static: largest friction at rest in N·m or N, ≥ coulomb, mean of both directions.
        speed: Stribeck speed in rad/s or m/s, > 0.
        asymmetry: share by which friction is larger forward and smaller backward.
    """

    joint: str
    coulomb: float
    static: float
    speed: float = 1.0
    asymmetry: float = 0.0

    def sliding(self, direction: float, velocity: float) -> float:
        """Magnitude of the sliding friction in a direction, ±1, at a velocity."""
        falling = (self.static - self.coulomb) * math.exp(-((velocity / self.speed) ** 2))
        return (1 + self.asymmetry * direction) * (self.coulomb + falling)

    def limit(self, direction: float) -> float:
        """Largest load in a direction, ±1, that a held joint bears."""
        return (1 + self.asymmetry * direction) * self.static
