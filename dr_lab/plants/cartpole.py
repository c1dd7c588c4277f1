"""The cart-pole: a cart on a level rail, a pole swinging below it, a DC motor on the cart."""

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
class CartPole(LagrangianMachine):
    """Equations of motion of the cart-pole in the state (x, θ, x', θ'), θ = 0 hanging down, positive towards +x.

    An element of the pole at distance s from its hinge is at (x + s sin θ, 0, −s cos θ). With M the cart's mass,
    m, S, J = ∫dm, ∫s dm, ∫s² dm of the pole and I_x, I_θ armatures,

        T = ½ (M + I_x + m) x'² + S cos θ x' θ' + ½ (J + I_θ) θ'²
        V = −(M + m) g_x x − S (g_x sin θ − g_z cos θ)

    and d/dt ∂T/∂q' − ∂T/∂q + ∂V/∂q = Q gives M(θ) q'' = f with

        M = [[M + I_x + m, S cos θ], [S cos θ, J + I_θ]]
        f_x = Q_x + S sin θ θ'² − ∂V/∂x
        f_θ = Q_θ               − ∂V/∂θ.
    """

    joints: tuple[str, ...] = ("cart", "pole")
    bodies: tuple[str, ...] = ("cart", "pole")
    actuators: tuple[str, ...] = ("motor",)

    def mass(self, position: Vector) -> Matrix:
        """M(θ) in kg, kg·m and kg·m²."""
        cart, pole = self.links
        across = pole.first * math.cos(position[1])
        return (cart.mass + self.armature[0] + pole.mass, across), (across, pole.second + self.armature[1])

    def own_force(self, position: Vector, velocity: Vector) -> Vector:
        """Gravity and centrifugal force (cart, pole) in N and N·m."""
        cart, pole = self.links
        along_x, _, along_z = self.gravity
        sine, cosine = math.sin(position[1]), math.cos(position[1])
        on_cart = pole.first * sine * velocity[1] ** 2 + (cart.mass + pole.mass) * along_x
        return on_cart, pole.first * (along_x * cosine + along_z * sine)

    def potential(self, position: Vector) -> float:
        """V in J, zero where the cart is at 0, the pole level and gravity vertical."""
        cart, pole = self.links
        along_x, _, along_z = self.gravity
        lean = along_x * math.sin(position[1]) - along_z * math.cos(position[1])
        return -(cart.mass + pole.mass) * along_x * position[0] - pole.first * lean


@dataclass(frozen=True, kw_only=True)
class CartPoleNominal(Nominal):
    """What the documents say of a cart-pole; its pole is a uniform thin rod.

    The motor turns the pinion through a planetary gear. With G = gear / pinion, the force on the cart is
    motor_efficiency · gear_efficiency · G k (u − k G x') / R, and the rotor weighs gear_efficiency · G² rotor.

    Attributes:
        cart_mass: kg.
        cart_damping: N·s/m.
        pole_mass: kg.
        pole_length: m.
        pole_damping: N·m·s/rad.
        motor_constant: k in N·m/A = V·s/rad.
        motor_resistance: R in Ω.
        motor_efficiency: 1.
        gear: turns of the motor for one of the pinion.
        gear_efficiency: 1.
        pinion: its radius, m.
        rotor: inertia of the motor's rotor, kg·m².
        gravity: m/s².
    """

    cart_mass: Positive
    cart_damping: NotNegative
    pole_mass: Positive
    pole_length: Positive
    pole_damping: NotNegative
    motor_constant: Positive
    motor_resistance: Positive
    motor_efficiency: Positive
    gear: Positive
    gear_efficiency: Positive
    pinion: Positive
    rotor: NotNegative
    gravity: Finite

    def documented(self) -> dict[str, float]:
        """Masses (kg) and dampings (N·s/m and N·m·s/rad)."""
        return {
            "cart.mass": self.cart_mass,
            "pole.mass": self.pole_mass,
            "cart.damping": self.cart_damping,
            "pole.damping": self.pole_damping,
        }

    def machine(self, true: Mapping[str, float]) -> CartPole:
        """The machine with given masses and dampings; motor, gear and length are as documented."""
        ratio = self.gear / self.pinion
        lossless = self.motor_resistance / (self.motor_efficiency * self.gear_efficiency)
        return CartPole(
            links=(Moments.point(true["cart.mass"], 0.0), Moments.rod(true["pole.mass"], self.pole_length)),
            damping=(true["cart.damping"], true["pole.damping"]),
            armature=(self.gear_efficiency * ratio**2 * self.rotor, 0.0),
            gravity=(0.0, 0.0, -self.gravity),
            drives=(Motor(ratio * self.motor_constant, lossless),),
        )
