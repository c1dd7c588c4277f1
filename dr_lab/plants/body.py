"""A machine with its hidden effect: its degrees of freedom, those that nobody measures included."""

from dataclasses import dataclass
from functools import cached_property

from dr_lab.errors import ConfigError
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect, Law, Motor, Oscillator
from dr_lab.plants.machine import Machine, Matrix, Vector, index
from dr_lab.plants.memory import Bristle, Memory, SlowCommand, SlowReading, SlowVelocity


@dataclass(frozen=True)
class Body:
    """Mass matrix and force of an altered machine in the state (q, q'); what turns unseen comes after the joints.

    Attributes:
        machine: with altered constants.
        laws: joint and law of each smooth force.
        frictions: joint and law of each dry friction.
        inside: joint and data of each hidden oscillator, then of each motor that turns by itself.
        memories: place and data of what is remembered: of a joint, or of an actuator for a command.
        at_motor: joints whose encoder sits at their hidden motor.

    Raises:
        ConfigError: two dry frictions sit at one joint, or two memories of a kind at one place, bristles apart.
        UnknownNameError: an effect names a joint, body or actuator that the machine does not have.
    """

    machine: Machine
    laws: tuple[tuple[int, Law], ...]
    frictions: tuple[tuple[int, DryFriction], ...]
    inside: tuple[tuple[int, Oscillator | Motor], ...]
    memories: tuple[tuple[int, Memory], ...] = ()
    at_motor: frozenset[int] = frozenset()

    @classmethod
    def of(cls, machine: Machine, effect: HiddenEffect) -> "Body":
        """The machine as the effect makes it."""

        def place(joint: str) -> int:
            return index("joint", joint, machine.joints)

        frictions = tuple((place(friction.joint), friction) for friction in effect.frictions())
        if len({joint for joint, _ in frictions}) < len(frictions):
            raise ConfigError(f"Hidden effect {effect.label}: two dry frictions at one joint; give their sum as one.")
        memories = tuple((_kept_at(memory, machine), memory) for memory in effect.memories())
        slow = [(type(memory), place) for place, memory in memories if not isinstance(memory, Bristle)]
        if len(set(slow)) < len(slow):
            raise ConfigError(
                f"Hidden effect {effect.label}: two memories of a kind at one place, as two lags at an actuator, "
                "of which the last alone would act; give one, or put them at two places."
            )
        return cls(
            effect.alter(machine),
            tuple((place(joint), law) for joint, law in effect.forces()),
            frictions,
            tuple((place(rotor.joint), rotor) for rotor in (*effect.oscillators(), *effect.motors())),
            memories,
            frozenset(place(joint) for joint in machine.joints if effect.read_at_motor(joint)),
        )

    @property
    def degrees(self) -> int:
        """Number of degrees of freedom."""
        return len(self.machine.joints) + len(self.inside)

    @property
    def read_columns(self) -> tuple[int, ...]:
        """Of each joint, the column of the state (positions, velocities, memories) that its encoder shows."""
        columns = list(range(len(self.machine.joints)))
        for row, (joint, rotor) in enumerate(self.inside, start=len(columns)):
            if isinstance(rotor, Motor) and joint in self.at_motor:
                columns[joint] = row
        for row, (joint, memory) in enumerate(self.memories, start=2 * self.degrees):
            if isinstance(memory, SlowReading):
                columns[joint] = row
        return tuple(columns)

    @property
    def velocity_columns(self) -> tuple[int, ...]:
        """Of each joint, the column of the state that its tachometer shows, which turns with the joint itself."""
        columns = [self.degrees + joint for joint in range(len(self.machine.joints))]
        for row, (joint, memory) in enumerate(self.memories, start=2 * self.degrees):
            if isinstance(memory, SlowVelocity):
                columns[joint] = row
        return tuple(columns)

    def acting(self, command: Vector, kept: Vector) -> Vector:
        """Commands that act: those that a driver is slow to follow are replaced by what it remembers."""
        if not kept:
            return command
        slow = {place: row for row, (place, memory) in enumerate(self.memories) if isinstance(memory, SlowCommand)}
        return [kept[slow[place]] if place in slow else value for place, value in enumerate(command)]

    def rates(self, position: Vector, velocity: Vector, command: Vector, kept: Vector) -> list[float]:
        """How fast each memory changes, in its unit per s."""
        rates = []
        for (place, memory), value in zip(self.memories, kept, strict=True):
            if isinstance(memory, Bristle | SlowVelocity):
                rates.append(memory.rate(value, velocity[place]))
            elif isinstance(memory, SlowCommand):
                rates.append(memory.rate(value, command[place]))
            else:
                rates.append(memory.rate(value, position[place]))
        return rates

    def terms(
        self,
        time: float,
        position: Vector,
        velocity: Vector,
        command: Vector,
        drag: Vector,
        kept: Vector = (),
    ) -> tuple[Matrix, Vector]:
        """Mass matrix and force, where dry friction adds `drag` to the force; time in s in the log."""
        applied = list(drag)
        for (joint, memory), value in zip(self.memories, kept, strict=True):
            if isinstance(memory, Bristle):
                speed = velocity[joint]
                applied[joint] += memory.force(value, memory.rate(value, speed), speed)
        command = self.acting(command, kept)
        for joint, law in self.laws:
            applied[joint] += law(time, position[joint], velocity[joint])
        if not self.inside:
            return self.machine.terms(position, velocity, command, applied)
        return self._with_inside(position, velocity, command, applied)

    def _with_inside(
        self, position: Vector, velocity: Vector, command: Vector, applied: list[float]
    ) -> tuple[Matrix, Vector]:
        own = len(self.machine.joints)
        for row, (joint, rotor) in enumerate(self.inside, start=own):
            pull = rotor.pull(position[row] - position[joint], velocity[row] - velocity[joint])
            applied[joint] += pull
            applied[row] -= pull
        mass, driven = self.machine.terms(position[:own], velocity[:own], command, applied[:own])
        force = [*driven, *applied[own:]]
        for row, (joint, rotor) in enumerate(self.inside, start=own):
            if isinstance(rotor, Motor):
                turned, spun = list(position[:own]), list(velocity[:own])
                force[joint] -= self._drive(joint, turned, spun, command)
                turned[joint], spun[joint] = position[row], velocity[row]
                force[row] += self._drive(joint, turned, spun, command)
        none = [0.0] * len(self.inside)
        rows = [[*row, *none] for row in mass]
        for row, (_, rotor) in enumerate(self.inside, start=own):
            rows.append([rotor.inertia if column == row else 0.0 for column in range(self.degrees)])
        return rows, force

    def _drive(self, joint: int, position: Vector, velocity: Vector, command: Vector) -> float:
        """Force of the drives at a joint, which may depend on where the joint is and how fast."""
        none = [0.0] * len(position)
        whole, rest = (m.terms(position, velocity, command, none)[1][joint] for m in (self.machine, self._undriven))
        return whole - rest

    @cached_property
    def _undriven(self) -> Machine:
        """The machine without its drives."""
        machine = self.machine
        for actuator in machine.actuators:
            machine = machine.with_drive_scaled(actuator, 0.0)
        return machine


def _kept_at(memory: Memory, machine: Machine) -> int:
    """Place of the joint, or of the actuator, that a memory belongs to."""
    if isinstance(memory, SlowCommand):
        return index("actuator", memory.actuator, machine.actuators)
    return index("joint", memory.joint, machine.joints)
