"""Several phenomena at once."""

from abc import abstractmethod
from collections.abc import Sequence

from dr_lab.plants.command import Command
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect, Law, Motor, Oscillator
from dr_lab.plants.machine import Machine
from dr_lab.plants.memory import Memory
from dr_lab.trajectory import Array


class Composite(HiddenEffect):
    """Each part on top of the one before: a command passes the first, then the next; so does a position that is read.

    What remembers stands apart from that order, next to the machine: a lag follows what all parts make of a command,
    and all parts make a reading of what a filter shows. So there is at most one of a kind at a place.
    """

    @property
    @abstractmethod
    def parts(self) -> Sequence[HiddenEffect]:
        """The phenomena, in order."""

    @property
    def label(self) -> str:
        """``name@site + name@site``."""
        return " + ".join(part.label for part in self.parts)

    @property
    def parameters(self) -> dict[str, object]:
        """Magnitudes of each, by its label."""
        return {part.label: part.parameters for part in self.parts}

    def alter(self, machine: Machine) -> Machine:
        """Altered by all."""
        for part in self.parts:
            machine = part.alter(machine)
        return machine

    def forces(self) -> tuple[tuple[str, Law], ...]:
        """The forces of all."""
        return tuple(force for part in self.parts for force in part.forces())

    def frictions(self) -> tuple[DryFriction, ...]:
        """The dry frictions of all, each at a joint of its own."""
        return tuple(friction for part in self.parts for friction in part.frictions())

    def oscillators(self) -> tuple[Oscillator, ...]:
        """What swings in any."""
        return tuple(oscillator for part in self.parts for oscillator in part.oscillators())

    def motors(self) -> tuple[Motor, ...]:
        """The motors of all, each at a joint of its own."""
        return tuple(motor for part in self.parts for motor in part.motors())

    def memories(self) -> tuple[Memory, ...]:
        """What any remembers."""
        return tuple(memory for part in self.parts for memory in part.memories())

    def command(self, actuator: str, command: Command) -> Command:
        """What the last makes of what those before it make of the command."""
        for part in self.parts:
            command = part.command(actuator, command)
        return command

    def reading_delay(self, joint: str) -> float:
        """The sum of the delays."""
        return sum(part.reading_delay(joint) for part in self.parts)

    def read_at_motor(self, joint: str) -> bool:
        """Whether any reads at the motor."""
        return any(part.read_at_motor(joint) for part in self.parts)

    def reading(self, joint: str, time: Array, position: Array) -> Array:
        """What the last makes of what those before it make of the position."""
        for part in self.parts:
            position = part.reading(joint, time, position)
        return position
