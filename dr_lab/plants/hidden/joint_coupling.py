"""A cable over pulleys at two joints."""

from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.hidden.rigid_effect import RigidEffect
from dr_lab.plants.machine import Machine, index
from dr_lab.plants.mujoco_machine import Coupling


@dataclass(frozen=True)
class JointCoupling(RigidEffect):
    """The cable's stretch is radius · q of the other joint − own radius · q − slack; it pulls at both pulleys.

    Attributes:
        site: joint of the second pulley.
        other: joint of the first one, before it.
        stiffness: N/m.
        radius: of the pulley at the other joint, m.
        own_radius: of the pulley at the site, m; negative where the cable crosses.
        slack: m.
    """

    name: ClassVar[str] = "joint_coupling"
    site: str
    other: str
    stiffness: float
    radius: float
    own_radius: float
    slack: float

    @property
    def parameters(self) -> dict[str, object]:
        """Magnitudes by name; the first is the stiffness that the other joint feels, in N·m/rad or N/m."""
        return {"stiffness_at_other": self.stiffness * self.radius**2, **super().parameters}

    def alter(self, machine: Machine) -> Machine:
        """The machine with the cable."""
        described = self.described(machine)
        joints = (index("joint", self.other, machine.joints), index("joint", self.site, machine.joints))
        return described.with_coupling(Coupling(joints, (self.radius, self.own_radius), self.slack, self.stiffness))
