"""Friction of a gear that grows with the torque that it carries."""

import math
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine


@dataclass(frozen=True)
class LoadDependentFriction(RigidEffect):
    """τ = −share |drive − outside| tanh(q' / creep); outside is what gravity and the motion itself exert.

    Attributes:
        site: joint.
        share: of the load.
        creep: rad/s or m/s, far below the speeds of the machine.
    """

    name: ClassVar[str] = "load_dependent_friction"
    site: str
    share: float
    creep: float

    def alter(self, machine: Machine) -> Machine:
        """The machine with the gear."""
        return self.described(machine).with_gear_law(self.site, self._added)

    def _added(self, drive: float, outside: float, velocity: float) -> float:
        return -self.share * abs(drive - outside) * math.tanh(velocity / self.creep)
