"""Drag of a medium on bodies that count as boxes."""

import numpy as np

from dr_lab.trajectory import Array


def half_lengths(mass: float, inertia: Array) -> Array:
    """Half-lengths in m of the box with a mass (kg) and principal inertias (kg·m²), shape (3,).

    I_i = m (r_j² + r_k²) / 3, hence r_i² = 3 (I_j + I_k − I_i) / (2 m).
    """
    if mass <= 0:
        return np.zeros(3)
    return np.sqrt(np.maximum(1.5 * (inertia.sum() - 2 * inertia) / mass, 0.0))


def box_drag(density: float, half: Array, velocity: Array, spin: Array) -> tuple[Array, Array]:
    """Force in N and torque in N·m on a box that moves through a medium, in the box's axes.

    f_i = −2 ρ r_j r_k |v_i| v_i and g_i = −½ ρ r_i (r_j⁴ + r_k⁴) |w_i| w_i: pressure ½ ρ v² on the faces, drag
    coefficient 1. Source: MuJoCo 4.0, computation chapter, "Fluid forces", inertia model.

    Args:
        density: ρ in kg/m³.
        half: r in m, shape (…, 3).
        velocity: of the box's centre relative to the medium, m/s, shape (…, 3).
        spin: rad/s, shape (…, 3).
    """
    others = half[..., [1, 2, 0]], half[..., [2, 0, 1]]
    force = -2.0 * density * others[0] * others[1] * np.abs(velocity) * velocity
    torque = -0.5 * density * half * (others[0] ** 4 + others[1] ** 4) * np.abs(spin) * spin
    return force, torque
