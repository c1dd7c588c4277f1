"""The Furuta (rotary) pendulum: an arm about the vertical, a pole swinging about the arm's length, a DC motor."""

import math
from dataclasses import dataclass

Pair = tuple[float, float]


@dataclass(frozen=True)
class Moments:
    """Mass moments of a slender body along a line, taken at the joint it hangs on.

    Attributes:
        mass: ∫dm in kg.
        first: ∫s dm in kg·m, s the distance from the joint.
        second: ∫s² dm in kg·m².
    """

    mass: float
    first: float
    second: float

    @classmethod
    def rod(cls, mass: float, length: float) -> "Moments":
        """Uniform thin rod that starts at the joint: m, m·l/2, m·l²/3."""
        return cls(mass, mass * length / 2, mass * length**2 / 3)

    @classmethod
    def point(cls, mass: float, distance: float) -> "Moments":
        """Point mass at a distance from the joint: m, m·d, m·d²."""
        return cls(mass, mass * distance, mass * distance**2)

    def __add__(self, other: "Moments") -> "Moments":
        return Moments(self.mass + other.mass, self.first + other.first, self.second + other.second)


@dataclass(frozen=True)
class Motor:
    """DC motor without inductance: torque = gain · k (u − k θ') / R.

    Attributes:
        constant: k, torque constant in N·m/A = back-EMF constant in V·s/rad.
        resistance: R in Ω.
        gain: share of the torque that reaches the arm, 1 for a perfect drive.
    """

    constant: float
    resistance: float
    gain: float = 1.0

    def torque(self, voltage: float, speed: float) -> float:
        """Torque on the arm in N·m at a terminal voltage in V and an arm speed in rad/s."""
        return self.gain * self.constant * (voltage - self.constant * speed) / self.resistance


@dataclass(frozen=True)
class Furuta:
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
        f_θ = τ − d_θ θ' − 2 J sin α cos α θ' α' + L S sin α α'² − ∂V/∂θ
        f_α =   − d_α α' +   J sin α cos α θ'²                  − ∂V/∂α.

    Attributes:
        arm: moments of the arm about the motor's axis.
        pole: moments of the pole about its hinge.
        length: L in m, from the motor's axis to the pole's hinge.
        damping: viscous friction (arm, pole) in N·m·s/rad.
        gravity: acceleration of gravity in the base's frame, m/s².
        motor: the motor on the arm.
        armature: rotor inertia (arm, pole) in kg·m², which joins a joint's own inertia only.
    """

    arm: Moments
    pole: Moments
    length: float
    damping: Pair
    gravity: tuple[float, float, float]
    motor: Motor
    armature: Pair = (0.0, 0.0)

    def mass(self, pole_angle: float) -> tuple[float, float, float]:
        """Mass matrix (M_θθ, M_θα, M_αα) in kg·m² at α in rad."""
        sine = math.sin(pole_angle)
        around = self.arm.second + self.armature[0] + self.pole.mass * self.length**2
        across = self.length * self.pole.first * math.cos(pole_angle)
        return around + self.pole.second * sine * sine, across, self.pole.second + self.armature[1]

    def force(self, position: Pair, velocity: Pair, voltage: float) -> Pair:
        """Right-hand side f (arm, pole) in N·m at angles in rad, speeds in rad/s and a voltage in V."""
        arm_speed, pole_speed = velocity
        sine, cosine = math.sin(position[1]), math.cos(position[1])
        swirl = self.pole.second * sine * cosine
        arm_weight, pole_weight = self._weight(position, sine, cosine)
        on_arm = self.motor.torque(voltage, arm_speed) - self.damping[0] * arm_speed + arm_weight
        on_arm += self.length * self.pole.first * sine * pole_speed**2 - 2 * swirl * arm_speed * pole_speed
        on_pole = swirl * arm_speed**2 - self.damping[1] * pole_speed + pole_weight
        return on_arm, on_pole

    def energy(self, position: Pair, velocity: Pair) -> float:
        """Kinetic plus potential energy in J; potential energy is zero where everything lies on the motor's axis."""
        around, across, pole = self.mass(position[1])
        arm_speed, pole_speed = velocity
        kinetic = 0.5 * around * arm_speed**2 + across * arm_speed * pole_speed + 0.5 * pole * pole_speed**2
        radial, tangential = self._horizontal_gravity(position[0])
        lean = math.sin(position[1]) * tangential - math.cos(position[1]) * self.gravity[2]
        return kinetic - (self.arm.first + self.pole.mass * self.length) * radial - self.pole.first * lean

    def _horizontal_gravity(self, arm_angle: float) -> Pair:
        along_x, along_y, _ = self.gravity
        sine, cosine = math.sin(arm_angle), math.cos(arm_angle)
        return along_x * cosine + along_y * sine, along_y * cosine - along_x * sine

    def _weight(self, position: Pair, sine: float, cosine: float) -> Pair:
        radial, tangential = self._horizontal_gravity(position[0])
        on_arm = (self.arm.first + self.pole.mass * self.length) * tangential - self.pole.first * sine * radial
        return on_arm, self.pole.first * (cosine * tangential + sine * self.gravity[2])
