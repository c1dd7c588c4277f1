"""The contract of a hidden effect: the ways in which one phenomenon can enter a Furuta pendulum."""

from typing import ClassVar

from dr_lab.errors import UnknownNameError
from dr_lab.plants.command import Command
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.furuta import Furuta, Pair

JOINTS = ("arm", "pole")


class HiddenEffect:
    """A phenomenon the nominal machine lacks; every method here is the machine without it.

    Attributes:
        name: the phenomenon's name.
        site: joint, actuator or body it sits at.
    """

    name: ClassVar[str]
    site: str

    @property
    def label(self) -> str:
        """``name@site``."""
        return f"{self.name}@{self.site}"

    def alter(self, machine: Furuta) -> Furuta:
        """The machine with other constants."""
        return machine

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """Smooth force added at (arm, pole) in N·m, at angles in rad and speeds in rad/s."""
        del position, velocity
        return 0.0, 0.0

    def friction(self) -> DryFriction | None:
        """Dry friction at one joint, or None."""
        return None

    def command(self, command: Command) -> Command:
        """What reaches the motor's terminals of the command applied to them."""
        return command

    def reading_delay(self) -> Pair:
        """How late the encoders (arm, pole) read, in s."""
        return 0.0, 0.0


def joint_index(site: str) -> int:
    """Index of a joint's name: arm 0, pole 1.

    Raises:
        UnknownNameError: the pendulum has no such joint.
    """
    if site not in JOINTS:
        raise UnknownNameError("joint", site, JOINTS, "the Furuta plant")
    return JOINTS.index(site)


def at_joint(site: str, value: float) -> Pair:
    """A pair (arm, pole) that is `value` at one joint and zero at the other."""
    index = joint_index(site)
    return (value, 0.0) if index == 0 else (0.0, value)
