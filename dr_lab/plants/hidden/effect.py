"""The contract of a hidden effect: the ways in which one phenomenon can enter a machine."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from dr_lab.plants.command import Command
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.machine import Machine
from dr_lab.plants.memory import Memory
from dr_lab.trajectory import Array

Law = Callable[[float, float, float], float]  # force in N·m or N at a time in the log, a joint's position and velocity


@dataclass(frozen=True)
class Oscillator:
    """A balanced rotor inside the link behind a joint, hung on a spring and a damper: one more degree of freedom.

    With φ its angle about the joint's axis, q the joint's, both in the frame in which the joint turns:
    inertia φ'' = −τ and the joint feels τ = stiffness (φ − q) + damping (φ' − q').

    Attributes:
        joint: name of the joint.
        inertia: kg·m² or kg.
        stiffness: N·m/rad or N/m.
        damping: N·m·s/rad or N·s/m.
    """

    joint: str
    inertia: float
    stiffness: float
    damping: float

    def pull(self, ahead: float, faster: float) -> float:
        """τ at the rotor's angle (rad or m) and speed relative to its joint."""
        return self.stiffness * ahead + self.damping * faster


@dataclass(frozen=True)
class Motor:
    """A joint's motor behind its transmission: one more degree of freedom, which the joint's drive turns.

    With φ its angle seen at the joint: inertia φ'' = drive(φ, φ') − pull(φ − q, φ' − q'), and the joint feels the pull
    instead of the drive. A back-EMF and a position controller's feedback are the motor's, too.

    Attributes:
        joint: name of the joint.
        inertia: kg·m² or kg, seen at the joint.
        pull: torque in N·m or force in N that the transmission passes on, from the motor's angle (rad or m) and speed
            relative to its joint.
    """

    joint: str
    inertia: float
    pull: Callable[[float, float], float]


class HiddenEffect:
    """A phenomenon the nominal machine lacks; every method here is the machine without it.

    Attributes:
        name: the phenomenon's name, as the catalogue has it where it knows the phenomenon.
        site: joint, actuator or body it sits at, or ``world``.
    """

    name: ClassVar[str]
    site: str

    @property
    def label(self) -> str:
        """``name@site``."""
        return f"{self.name}@{self.site}"

    @property
    def parameters(self) -> dict[str, object]:
        """Magnitudes by name."""
        return {key: value for key, value in vars(self).items() if key != "site"}

    def alter(self, machine: Machine) -> Machine:
        """The machine with other constants."""
        return machine

    def forces(self) -> tuple[tuple[str, Law], ...]:
        """Smooth forces, each with the joint it acts on."""
        return ()

    def frictions(self) -> tuple[DryFriction, ...]:
        """Dry friction, at most one at each joint."""
        return ()

    def oscillators(self) -> tuple[Oscillator, ...]:
        """What swings unseen inside of links."""
        return ()

    def motors(self) -> tuple[Motor, ...]:
        """Motors that do not turn as their joints do."""
        return ()

    def memories(self) -> tuple[Memory, ...]:
        """What it remembers beside the machine's own motion."""
        return ()

    def command(self, actuator: str, command: Command) -> Command:
        """What an actuator makes of the command sent to it; each sample by itself, whatever came before."""
        del actuator
        return command

    def reading_delay(self, joint: str) -> float:
        """How late a joint's encoder reads, in s."""
        del joint
        return 0.0

    def read_at_motor(self, joint: str) -> bool:
        """Whether a joint's encoder sits at its hidden motor instead of at the link."""
        del joint
        return False

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """What a joint's encoder makes of positions (rad or m) at times in the log (s); both (n,)."""
        del joint, time
        return position


class JointForce(HiddenEffect, ABC):
    """A smooth force at one joint, the effect's site."""

    @abstractmethod
    def force(self, time: float, position: float, velocity: float) -> float:
        """Force in N·m or N at a time (s) in the log, the joint's position (rad or m) and its velocity."""

    def forces(self) -> tuple[tuple[str, Law], ...]:
        """The force at the site."""
        return ((self.site, self.force),)
