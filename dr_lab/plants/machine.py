"""What every machine of a bench has in common."""

from collections.abc import Sequence
from typing import Protocol, Self

from dr_lab.errors import UnknownNameError

Vector = Sequence[float]
Matrix = Sequence[Sequence[float]]
Gravity = tuple[float, float, float]


class Machine(Protocol):
    """A machine with n degrees of freedom q, whose motion is M(q) q'' = f.

    A machine does not change; what alters it gives another one. Forces are in N·m at hinges and in N at slides; so with
    all other units.
    """

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of its n joints."""
        ...

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of what each joint moves."""
        ...

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of its m actuators."""
        ...

    @property
    def gravity(self) -> Gravity:
        """Acceleration of gravity in the base's frame, m/s²."""
        ...

    def terms(self, position: Vector, velocity: Vector, command: Vector, applied: Vector) -> tuple[Matrix, Vector]:
        """Mass matrix M and force f.

        Args:
            position: q in rad or m, length n.
            velocity: q' in rad/s or m/s, length n.
            command: one for each actuator, length m.
            applied: forces from outside on each joint, part of f, length n.
        """
        ...

    def with_armature(self, joint: str, inertia: float) -> Self:
        """With rotor inertia (kg·m² or kg) added at a joint: ½ inertia q'² more kinetic energy."""
        ...

    def with_load(self, body: str, mass: float, distance: float) -> Self:
        """With a point mass (kg) on a body's own line, at a distance (m) from its joint."""
        ...

    def with_gravity(self, gravity: Gravity) -> Self:
        """In another gravity, m/s²."""
        ...

    def with_drive_scaled(self, actuator: str, share: float) -> Self:
        """With an actuator of whose documented force only a share arrives."""
        ...


def index(kind: str, name: str, names: Sequence[str]) -> int:
    """Place of a name among those of a machine.

    Raises:
        UnknownNameError: the machine has no such joint, body or actuator.
    """
    if name not in names:
        raise UnknownNameError(kind, name, names, "the plant")
    return names.index(name)
