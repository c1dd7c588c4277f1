"""Something loose inside a link that swings on its own."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.effect import HiddenEffect, Oscillator


@dataclass(frozen=True)
class FlexibleMode(HiddenEffect):
    """An unmeasured rotor that the link drags along by a spring and a damper.

    Attributes:
        site: joint of the link.
        inertia: kg·m² or kg.
        stiffness: N·m/rad or N/m.
        damping: N·m·s/rad or N·s/m.
    """

    name: ClassVar[str] = "flexible_mode"
    site: str
    inertia: float
    stiffness: float
    damping: float

    def oscillators(self) -> tuple[Oscillator, ...]:
        """The rotor."""
        return (Oscillator(self.site, self.inertia, self.stiffness, self.damping),)
