"""The simple pendulum, driven by a torque."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.bounds import Finite, NotNegative, Positive
from dr_lab.plants.drive import ForceDrive
from dr_lab.plants.lagrangian import LagrangianMachine
from dr_lab.plants.machine import Matrix, Vector
from dr_lab.plants.moments import Moments
from dr_lab.plants.nominal import Nominal


@dataclass(frozen=True, kw_only=True)
class Pendulum(LagrangianMachine):
    """(J + I_a) θ'' = Q + S (g_x cos θ + g_z sin θ), θ = 0 hanging down, positive towards +x.

    An element of the link at distance s from the joint is at s (sin θ, 0, −cos θ), so V = −S (g_x sin θ − g_z cos θ)
    with S, J = ∫s dm, ∫s² dm; I_a is the armature.
    """

    joints: tuple[str, ...] = ("pendulum",)
    bodies: tuple[str, ...] = ("link",)
    actuators: tuple[str, ...] = ("motor",)

    def mass(self, position: Vector) -> Matrix:
        """Inertia in kg·m², the same everywhere."""
        del position
        return ((self.links[0].second + self.armature[0],),)

    def own_force(self, position: Vector, velocity: Vector) -> Vector:
        """Gravity in N·m."""
        del velocity
        along_x, _, along_z = self.gravity
        return (self.links[0].first * (along_x * math.cos(position[0]) + along_z * math.sin(position[0])),)

    def potential(self, position: Vector) -> float:
        """V in J, zero where the link is level and gravity vertical."""
        along_x, _, along_z = self.gravity
        return -self.links[0].first * (along_x * math.sin(position[0]) - along_z * math.cos(position[0]))


@dataclass(frozen=True, kw_only=True)
class PendulumNominal(Nominal):
    """What the documents say of a simple pendulum.

    Attributes:
        mass: of the link, kg.
        centre: distance of the link's centre from the joint, m.
        inertia: of the link about its centre, kg·m²; it scales with the mass.
        rotor: inertia of the rotor seen at the joint, kg·m².
        gravity: m/s².
    """

    mass: Positive
    centre: NotNegative
    inertia: NotNegative
    rotor: NotNegative
    gravity: Finite

    def documented(self) -> dict[str, float]:
        """Mass (kg) and centre (m)."""
        return {"link.mass": self.mass, "link.com": self.centre}

    def machine(self, true: Mapping[str, float]) -> Pendulum:
        """The machine with a given mass and centre."""
        mass = true["link.mass"]
        return Pendulum(
            links=(Moments.body(mass, true["link.com"], self.inertia * mass / self.mass),),
            damping=(0.0,),
            armature=(self.rotor,),
            gravity=(0.0, 0.0, -self.gravity),
            drives=(ForceDrive(),),
        )
