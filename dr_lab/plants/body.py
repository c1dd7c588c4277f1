"""A machine with its hidden effect: its degrees of freedom, those that nobody measures included."""

from dataclasses import dataclass

from dr_lab.errors import ConfigError
from dr_lab.plants.dry_friction import DryFriction
from dr_lab.plants.hidden.effect import HiddenEffect, Law, Motor, Oscillator
from dr_lab.plants.machine import Machine, Matrix, Vector, index


@dataclass(frozen=True)
class Body:
    """Mass matrix and force of an altered machine in the state (q, q'); what turns unseen comes after the joints.

    Attributes:
        machine: with altered constants.
        laws: joint and law of each smooth force.
        frictions: joint and law of each dry friction.
        inside: joint and data of each hidden oscillator, then of each motor that turns by itself.

    Raises:
        ConfigError: two dry frictions sit at one joint.
        UnknownNameError: an effect names a joint, body or actuator that the machine does not have.
    """

    machine: Machine
    laws: tuple[tuple[int, Law], ...]
    frictions: tuple[tuple[int, DryFriction], ...]
    inside: tuple[tuple[int, Oscillator | Motor], ...]

    @classmethod
    def of(cls, machine: Machine, effect: HiddenEffect) -> "Body":
        """The machine as the effect makes it."""

        def place(joint: str) -> int:
            return index("joint", joint, machine.joints)

        frictions = tuple((place(friction.joint), friction) for friction in effect.frictions())
        if len({joint for joint, _ in frictions}) < len(frictions):
            raise ConfigError(f"Hidden effect {effect.label}: two dry frictions at one joint; give their sum as one.")
        return cls(
            effect.alter(machine),
            tuple((place(joint), law) for joint, law in effect.forces()),
            frictions,
            tuple((place(rotor.joint), rotor) for rotor in (*effect.oscillators(), *effect.motors())),
        )

    @property
    def degrees(self) -> int:
        """Number of degrees of freedom."""
        return len(self.machine.joints) + len(self.inside)

    def terms(
        self, time: float, position: Vector, velocity: Vector, command: Vector, drag: Vector
    ) -> tuple[Matrix, Vector]:
        """Mass matrix and force, where dry friction adds `drag` to the force; time in s in the log."""
        applied = list(drag)
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
        motors = [(row, joint) for row, (joint, rotor) in enumerate(self.inside, start=own) if isinstance(rotor, Motor)]
        if motors:
            _, idle = self.machine.terms(position[:own], velocity[:own], [0.0] * len(command), applied[:own])
            for row, joint in motors:
                force[row] += driven[joint] - idle[joint]
                force[joint] = idle[joint]
        none = [0.0] * len(self.inside)
        rows = [[*row, *none] for row in mass]
        for row, (_, rotor) in enumerate(self.inside, start=own):
            rows.append([rotor.inertia if column == row else 0.0 for column in range(self.degrees)])
        return rows, force
