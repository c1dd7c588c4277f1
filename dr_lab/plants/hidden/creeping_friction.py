"""Dry friction of a joint that shares its load with a contact."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.bounds import NotNegative, Positive
from dr_lab.plants.hidden.effect import JointForce


@dataclass(frozen=True)
class CreepingFriction(JointForce):
    """τ = −torque tanh(q' / creep), Coulomb friction that holds a joint all but still.

    Where a contact resists the same motion, what each bears at rest is not determined; so the joint creeps a little
    instead of being held.

    Attributes:
        site: joint.
        torque: N·m, or N at a slide.
        creep: rad/s or m/s, far below the speeds of the machine.
    """

    name: ClassVar[str] = "coulomb_friction"
    site: str
    torque: NotNegative
    creep: Positive

    def force(self, time: float, position: float, velocity: float) -> float:
        """Friction at the joint."""
        del time, position
        return -self.torque * math.tanh(velocity / self.creep)


@dataclass(frozen=True)
class ShowingCreep(CreepingFriction):
    """The same with a creep that the logs may show, which is no Coulomb friction."""

    name: ClassVar[str] = "smooth_friction"
