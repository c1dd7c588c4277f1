"""The Furuta (rotary) pendulum: an arm about the vertical, a pole swinging about the arm's length, a DC motor."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.bounds import Finite, NotNegative, Positive
from dr_lab.plants.drive import Motor
from dr_lab.plants.lagrangian import LagrangianMachine
from dr_lab.plants.machine import Matrix, Vector
from dr_lab.plants.moments import Moments
from dr_lab.plants.nominal import Nominal


@dataclass(frozen=True, kw_only=True)
class Furuta(LagrangianMachine):
    """Equations of motion of the Furuta pendulum in the state (θ, α, θ', α').

    θ turns the arm about the vertical +z; the arm points along e_r(θ), with e_t = e_z × e_r. The pole's hinge sits at
    the arm's tip, radius L, and its axis is e_r; α = 0 hangs down and positive α carries the pole's tip towards e_t.

    Derivation. An element of the pole at distance s from its hinge is at L e_r + s (sin α e_t − cos α e_z), so

        v² = L² θ'² + 2 L s cos α θ' α' + s² α'² + s² sin² α θ'².

    With ∫dm, ∫s dm, ∫s² dm = m, S, J of the pole, I = ∫r² dm of the arm, and I_a, I_p armatures,

        T = ½ (I + I_a + m L² + J sin² α) θ'² + L S cos α θ' α' + ½ (J + I_p) α'²
        V = −(A + m L) (g_x cos θ + g_y sin θ) − S (sin α (g_y cos θ − g_x sin θ) − g_z cos α),   A = ∫r dm of the arm,

    and d/dt ∂T/∂q' − ∂T/∂q + ∂V/∂q = Q gives M(α) q'' = f with

        M = [[I + I_a + m L² + J sin² α, L S cos α], [L S cos α, J + I_p]]
        f_θ = Q_θ − 2 J sin α cos α θ' α' + L S sin α α'² − ∂V/∂θ
        f_α = Q_α +   J sin α cos α θ'²                  − ∂V/∂α.

    Attributes:
        length: L in m, from the motor's axis to the pole's hinge.
    """

    joints: tuple[str, ...] = ("arm", "pole")
    bodies: tuple[str, ...] = ("arm", "pole")
    actuators: tuple[str, ...] = ("motor",)
    length: float

    def mass(self, position: Vector) -> Matrix:
        """M(α) in kg·m²."""
        arm, pole = self.links
        sine = math.sin(position[1])
        around = arm.second + self.armature[0] + pole.mass * self.length**2 + pole.second * sine * sine
        across = self.length * pole.first * math.cos(position[1])
        return (around, across), (across, pole.second + self.armature[1])

    def own_force(self, position: Vector, velocity: Vector) -> Vector:
        """Gravity, centrifugal and Coriolis force (arm, pole) in N·m."""
        arm, pole = self.links
        arm_speed, pole_speed = velocity
        sine, cosine = math.sin(position[1]), math.cos(position[1])
        swirl = pole.second * sine * cosine
        radial, tangential = self._horizontal_gravity(position[0])
        on_arm = (arm.first + pole.mass * self.length) * tangential - pole.first * sine * radial
        on_arm += self.length * pole.first * sine * pole_speed**2 - 2 * swirl * arm_speed * pole_speed
        return on_arm, swirl * arm_speed**2 + pole.first * (cosine * tangential + sine * self.gravity[2])

    def potential(self, position: Vector) -> float:
        """V in J, zero where everything lies on the motor's axis."""
        arm, pole = self.links
        radial, tangential = self._horizontal_gravity(position[0])
        lean = math.sin(position[1]) * tangential - math.cos(position[1]) * self.gravity[2]
        return -(arm.first + pole.mass * self.length) * radial - pole.first * lean

    def _horizontal_gravity(self, arm_angle: float) -> tuple[float, float]:
        along_x, along_y, _ = self.gravity
        sine, cosine = math.sin(arm_angle), math.cos(arm_angle)
        return along_x * cosine + along_y * sine, along_y * cosine - along_x * sine


@dataclass(frozen=True, kw_only=True)
class FurutaNominal(Nominal):
    """What the documents say of a Furuta pendulum; its links are uniform thin rods.

    Attributes:
        arm_mass: kg.
        arm_length: m.
        arm_damping: N·m·s/rad.
        pole_mass: kg.
        pole_length: m.
        pole_damping: N·m·s/rad.
        motor_constant: N·m/A = V·s/rad.
        motor_resistance: Ω.
        gravity: m/s².
    """

    arm_mass: Positive
    arm_length: Positive
    arm_damping: NotNegative
    pole_mass: Positive
    pole_length: Positive
    pole_damping: NotNegative
    motor_constant: Positive
    motor_resistance: Positive
    gravity: Finite

    def documented(self) -> dict[str, float]:
        """Masses (kg) and dampings (N·m·s/rad)."""
        return {
            "arm.mass": self.arm_mass,
            "pole.mass": self.pole_mass,
            "arm.damping": self.arm_damping,
            "pole.damping": self.pole_damping,
        }

    def machine(self, true: Mapping[str, float]) -> Furuta:
        """The machine with given masses and dampings; lengths, motor and gravity are as documented."""
        return Furuta(
            links=(
                Moments.rod(true["arm.mass"], self.arm_length),
                Moments.rod(true["pole.mass"], self.pole_length),
            ),
            damping=(true["arm.damping"], true["pole.damping"]),
            armature=(0.0, 0.0),
            gravity=(0.0, 0.0, -self.gravity),
            drives=(Motor(self.motor_constant, self.motor_resistance),),
            length=self.arm_length,
        )
