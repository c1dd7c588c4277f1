"""The double pendulum, driven by torques at shoulder and elbow."""

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
class DoublePendulum(LagrangianMachine):
    """Equations of motion of the planar double pendulum in the state (θ, φ, θ', φ').

    θ is the shoulder, 0 hanging down and positive towards +x; φ is the elbow, relative to the first link. An element
    of the second link at distance s from the elbow is at L (sin θ, 0, −cos θ) + s (sin(θ + φ), 0, −cos(θ + φ)). The
    second motor sits at the shoulder, fixed to the first link; its rotor turns with θ − N φ. With S_i, J_i = ∫s dm,
    ∫s² dm of link i, m the second's mass, I_s, I_e armatures and I_r the second rotor's inertia before the gear,

        T = ½ (J_1 + I_s + m L²) θ'² + L S_2 cos φ θ' (θ' + φ') + ½ J_2 (θ' + φ')² + ½ I_e φ'² + ½ I_r (θ' − N φ')²
        V = −(S_1 + m L)(g_x sin θ − g_z cos θ) − S_2 (g_x sin(θ + φ) − g_z cos(θ + φ))

    and d/dt ∂T/∂q' − ∂T/∂q + ∂V/∂q = Q gives M(φ) q'' = f with

        M_θθ = J_1 + I_s + m L² + J_2 + 2 L S_2 cos φ + I_r
        M_θφ = J_2 + L S_2 cos φ − N I_r
        M_φφ = J_2 + I_e + N² I_r
        f_θ = Q_θ + L S_2 sin φ (2 θ' φ' + φ'²) − ∂V/∂θ
        f_φ = Q_φ − L S_2 sin φ θ'²             − ∂V/∂φ.

    Attributes:
        length: L in m, from shoulder to elbow.
        rotor: I_r in kg·m².
        gear: N.
    """

    joints: tuple[str, ...] = ("shoulder", "elbow")
    bodies: tuple[str, ...] = ("link1", "link2")
    actuators: tuple[str, ...] = ("shoulder", "elbow")
    length: float
    rotor: float
    gear: float

    def mass(self, position: Vector) -> Matrix:
        """M(φ) in kg·m²."""
        first, second = self.links
        coupling = self.length * second.first * math.cos(position[1])
        shoulder = first.second + self.armature[0] + second.mass * self.length**2 + second.second + 2 * coupling
        across = second.second + coupling - self.gear * self.rotor
        elbow = second.second + self.armature[1] + self.gear**2 * self.rotor
        return (shoulder + self.rotor, across), (across, elbow)

    def own_force(self, position: Vector, velocity: Vector) -> Vector:
        """Gravity, centrifugal and Coriolis force (shoulder, elbow) in N·m."""
        first, second = self.links
        swirl = self.length * second.first * math.sin(position[1])
        below = second.first * self._across(position[0] + position[1])
        own = (first.first + second.mass * self.length) * self._across(position[0])
        turning, folding = velocity
        return own + below + swirl * (2 * turning * folding + folding**2), below - swirl * turning**2

    def potential(self, position: Vector) -> float:
        """V in J, zero where both links are level and gravity vertical."""
        first, second = self.links
        along_x, _, along_z = self.gravity

        def height(angle: float) -> float:
            return along_z * math.cos(angle) - along_x * math.sin(angle)

        upper = (first.first + second.mass * self.length) * height(position[0])
        return upper + second.first * height(position[0] + position[1])

    def _across(self, angle: float) -> float:
        """Gravity across a link that points at an angle, m/s²."""
        along_x, _, along_z = self.gravity
        return along_x * math.cos(angle) + along_z * math.sin(angle)


@dataclass(frozen=True, kw_only=True)
class DoublePendulumNominal(Nominal):
    """What the documents say of a double pendulum; inertias are about the links' centres and scale with the masses.

    Attributes:
        mass1: kg.
        centre1: distance of the first link's centre from the shoulder, m.
        inertia1: kg·m².
        length1: from shoulder to elbow, m.
        mass2: kg.
        centre2: distance of the second link's centre from the elbow, m.
        inertia2: kg·m².
        rotor: inertia of either motor's rotor before the gear, kg·m².
        gear: of either motor.
        gravity: m/s².
    """

    mass1: Positive
    centre1: NotNegative
    inertia1: NotNegative
    length1: Positive
    mass2: Positive
    centre2: NotNegative
    inertia2: NotNegative
    rotor: NotNegative
    gear: Positive
    gravity: Finite

    def documented(self) -> dict[str, float]:
        """Masses (kg) and shares of the inertias about the centres (1)."""
        return {
            "link1.mass": self.mass1,
            "link1.inertia_scale": 1.0,
            "link2.mass": self.mass2,
            "link2.inertia_scale": 1.0,
        }

    def machine(self, true: Mapping[str, float]) -> DoublePendulum:
        """The machine with given masses and inertias; lengths, centres and rotors are as documented."""
        mass1, mass2 = true["link1.mass"], true["link2.mass"]
        inertia1 = true["link1.inertia_scale"] * self.inertia1 * mass1 / self.mass1
        inertia2 = true["link2.inertia_scale"] * self.inertia2 * mass2 / self.mass2
        return DoublePendulum(
            links=(Moments.body(mass1, self.centre1, inertia1), Moments.body(mass2, self.centre2, inertia2)),
            damping=(0.0, 0.0),
            armature=(self.gear**2 * self.rotor, 0.0),
            gravity=(0.0, 0.0, -self.gravity),
            drives=(ForceDrive(), ForceDrive()),
            length=self.length1,
            rotor=self.rotor,
            gear=self.gear,
        )
