"""Machines whose equations are written out from their Lagrangian."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Self

from dr_lab.plants.drive import Drive
from dr_lab.plants.machine import Gravity, Matrix, Vector, index
from dr_lab.plants.moments import Moments


@dataclass(frozen=True, kw_only=True)
class LagrangianMachine(ABC):
    """M(q) q'' = f with f = own(q, q') − damping · q' + drives + applied; actuator i drives joint i.

    Attributes:
        joints: names of the joints.
        bodies: names of the links.
        actuators: names of the drives.
        links: mass moments of each link about its joint.
        damping: viscous friction of each joint in N·m·s/rad or N·s/m.
        armature: rotor inertia of each joint in kg·m² or kg, which joins a joint's own inertia only.
        gravity: acceleration of gravity in the base's frame, m/s².
        drives: of the first joints.
    """

    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    actuators: tuple[str, ...]
    links: tuple[Moments, ...]
    damping: tuple[float, ...]
    armature: tuple[float, ...]
    gravity: Gravity
    drives: tuple[Drive, ...]

    @abstractmethod
    def mass(self, position: Vector) -> Matrix:
        """Mass matrix in kg·m², kg·m or kg, armatures included."""

    @abstractmethod
    def own_force(self, position: Vector, velocity: Vector) -> Vector:
        """Gravity and what comes of the motion itself, −∂V/∂q + ∂T/∂q − (d/dt M) q', in N·m or N."""

    @abstractmethod
    def potential(self, position: Vector) -> float:
        """Potential energy V in J."""

    def terms(self, position: Vector, velocity: Vector, command: Vector, applied: Vector) -> tuple[Matrix, Vector]:
        """Mass matrix and force."""
        own = self.own_force(position, velocity)
        force = [f + a - d * speed for f, a, d, speed in zip(own, applied, self.damping, velocity, strict=True)]
        for joint, drive in enumerate(self.drives):
            force[joint] += drive.force(command[joint], velocity[joint])
        return self.mass(position), force

    def energy(self, position: Vector, velocity: Vector) -> float:
        """Kinetic plus potential energy in J."""
        rows = self.mass(position)
        kinetic = sum(
            m * a * b for row, a in zip(rows, velocity, strict=True) for m, b in zip(row, velocity, strict=True)
        )
        return 0.5 * kinetic + self.potential(position)

    def with_armature(self, joint: str, inertia: float) -> Self:
        """With rotor inertia at a joint."""
        armature = list(self.armature)
        armature[index("joint", joint, self.joints)] += inertia
        return replace(self, armature=tuple(armature))

    def with_load(self, body: str, mass: float, distance: float) -> Self:
        """With a point mass on a link's own line."""
        links = list(self.links)
        links[index("body", body, self.bodies)] += Moments.point(mass, distance)
        return replace(self, links=tuple(links))

    def with_gravity(self, gravity: Gravity) -> Self:
        """In another gravity."""
        return replace(self, gravity=gravity)

    def with_drive_scaled(self, actuator: str, share: float) -> Self:
        """With a weaker (or stronger) drive."""
        drives = list(self.drives)
        place = index("actuator", actuator, self.actuators)
        drives[place] = drives[place].scaled(share)
        return replace(self, drives=tuple(drives))
