"""A floor that is not level."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dr_lab.errors import ConfigError
from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine
from dr_lab.plants.pinocchio_machine import PinocchioMachine


@dataclass(frozen=True)
class FloorSlope(RigidEffect):
    """The plane is turned about its origin by the vector (about_x, about_y, 0); gravity stays.

    Attributes:
        site: the plane.
        about_x: rad.
        about_y: rad.
    """

    name: ClassVar[str] = "floor_slope"
    site: str
    about_x: float = 0.0
    about_y: float = 0.0

    def alter(self, machine: Machine) -> Machine:
        """The machine above that floor.

        Raises:
            ConfigError: the machine cannot touch a floor.
        """
        own = self.described(machine)
        if isinstance(own, PinocchioMachine):
            raise ConfigError(f"Hidden effect {self.label}: this machine has no contacts. Give plant=bouncer.")
        angle = math.hypot(self.about_x, self.about_y)
        share = math.sin(angle / 2) / angle if angle else 0.5
        turn = np.array([math.cos(angle / 2), share * self.about_x, share * self.about_y, 0.0])
        return own.with_floor_turned(self.site, turn)
