"""How the mass of a link is spread along it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Moments:
    """Mass moments of a slender body along a line, taken at the joint it hangs on.

    Attributes:
        mass: ∫dm in kg.
        first: ∫s dm in kg·m, s the distance from the joint.
        second: ∫s² dm in kg·m².
    """

    mass: float
    first: float
    second: float

    @classmethod
    def rod(cls, mass: float, length: float) -> "Moments":
        """Uniform thin rod that starts at the joint: m, m·l/2, m·l²/3."""
        return cls(mass, mass * length / 2, mass * length**2 / 3)

    @classmethod
    def point(cls, mass: float, distance: float) -> "Moments":
        """Point mass at a distance from the joint: m, m·d, m·d²."""
        return cls(mass, mass * distance, mass * distance**2)

    @classmethod
    def body(cls, mass: float, centre: float, inertia: float) -> "Moments":
        """Body with its centre at a distance from the joint and an inertia about that centre: m, m·c, I + m·c²."""
        return cls(mass, mass * centre, inertia + mass * centre**2)

    def __add__(self, other: "Moments") -> "Moments":
        return Moments(self.mass + other.mass, self.first + other.first, self.second + other.second)
