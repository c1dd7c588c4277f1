"""The law of dry friction at one joint: what it can hold, and what it takes from a sliding joint."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class DryFriction:
    """Dry friction that holds a joint up to a limit and brakes it while it slides.

    While the joint is held |τ| ≤ static; while it slides

        |τ|(v) = coulomb + (static − coulomb) exp(−(v / speed)²).

    A held joint does not creep: sticking is a constraint, left when the force it needs exceeds `static`.

    Attributes:
        joint: index of the joint.
        coulomb: sliding friction at high speed in N·m.
        static: largest friction at rest in N·m, ≥ coulomb.
        speed: Stribeck speed in rad/s, > 0.
    """

    joint: int
    coulomb: float
    static: float
    speed: float = 1.0

    def sliding(self, velocity: float) -> float:
        """Magnitude of the sliding friction in N·m at a speed in rad/s."""
        return self.coulomb + (self.static - self.coulomb) * math.exp(-((velocity / self.speed) ** 2))
