"""Mass, centre and inertia of a rigid body from ten numbers, every one of which gives a body that can exist."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from dr_lab.trajectory import Array

SHORT = (
    "mass",
    "shift_x", "shift_y", "shift_z",
    "stretch_x", "stretch_y", "stretch_z",
    "shear_xy", "shear_yz", "shear_xz",
)  # fmt: skip
_SHEARS = ((0, 1), (1, 2), (0, 2))
_THIN = 1e-8  # share of the largest second moment that a rod's or a sheet's thickness counts as


@dataclass(frozen=True)
class Inertial:
    """What n bodies weigh, and where.

    Attributes:
        mass: shape (n,), kg.
        centre: of mass in the body's frame, shape (n, 3), m.
        moments: principal moments of inertia about the centre, shape (n, 3), kg·m².
        axes: quaternions of the principal axes in the body's frame, shape (n, 4).
    """

    mass: Array
    centre: Array
    moments: Array
    axes: Array

    @property
    def tensor(self) -> Array:
        """Inertia about the centre in the body's frame, shape (n, 3, 3), kg·m²."""
        turned = _rotation(self.axes).as_matrix()
        return (turned * self.moments[:, None, :]) @ turned.transpose(0, 2, 1)


def second_moments(tensor: Array) -> Array:
    """∫ x xᵀ dm about the centre, from the inertia there: Σ = tr(I)/2 · 1 − I, shape (…, 3, 3)."""
    return np.trace(tensor, axis1=-2, axis2=-1)[..., None, None] / 2 * np.eye(3) - tensor


def principal(second: Array) -> tuple[Array, Array]:
    """Principal moments of inertia (…, 3), and quaternions of their axes (…, 4), of second moments Σ (…, 3, 3)."""
    values, axes = np.linalg.eigh(second)
    values = np.maximum(values, 0.0)
    axes[np.linalg.det(axes) < 0, :, 0] *= -1.0
    # Sums of two, not the sum of all less one: so A + B ≥ C is kept to the last bit, which MuJoCo asks for.
    return values[..., [1, 0, 0]] + values[..., [2, 2, 1]], Rotation.from_matrix(axes).as_quat()[..., _LAST]


@dataclass(frozen=True)
class LogCholesky:
    """Bodies near a nominal one, by ten numbers that are 0 for the nominal body and have no unit.

    The pseudo-inertia J = [[Σ + m c cᵀ, m c], [m cᵀ, m]] is that of a body that can exist if, and only if, it is
    positive definite. With its nominal factor U₀ (upper triangular, J₀ = U₀ U₀ᵀ), J = U₀ L Lᵀ U₀ᵀ with
    L = exp(μ/2) [[D, t], [0, 1]], D upper triangular with the diagonal exp(dᵢ), is so for every μ, t, d and s:

    mass m = m₀ exp(μ), which takes the inertia along; centre c = c₀ + R₀ t, with Σ₀/m₀ = R₀ R₀ᵀ, so that t is in radii
    of gyration; Σ/m = R₀ D Dᵀ R₀ᵀ, so that dᵢ stretches the body along an axis and s shears it. With R₀ of a body's
    principal axes along its frame, Iₓₓ = m (σ_y² exp(2 d_y) + σ_z² exp(2 d_z)).

    A rod stays thin: its second moments across are taken as 1e-8 of the one along.

    Source: Rucker and Wensing, IEEE Robotics and Automation Letters 7 (2022) 2756; Wensing, Kim and Slotine, the same 3
    (2018) 60.

    Attributes:
        mass: m₀, kg.
        centre: c₀, shape (3,), m.
        root: R₀, shape (3, 3), m.
    """

    mass: float
    centre: Array
    root: Array

    @classmethod
    def of(cls, mass: float, centre: Array, tensor: Array) -> "LogCholesky":
        """The ten numbers' frame of a nominal body with a mass and a size; the tensor about its centre."""
        values, axes = np.linalg.eigh(second_moments(tensor) / mass)
        thick = np.maximum(values, _THIN * values[-1])
        flip = np.eye(3)[::-1]
        lower = np.linalg.cholesky(flip @ (axes * thick) @ axes.T @ flip)
        return cls(mass, centre, flip @ lower @ flip)

    def at(self, theta: Array) -> Inertial:
        """The bodies at ten numbers each, in the order of `SHORT`; shape (n, 10)."""
        mass, shift, stretch, shear = np.split(theta, (1, 4, 7), axis=1)
        deformed = np.zeros((len(theta), 3, 3))
        deformed[:, range(3), range(3)] = np.exp(stretch)
        for column, place in enumerate(_SHEARS):
            deformed[:, *place] = shear[:, column]
        root = self.root @ deformed
        weight = self.mass * np.exp(mass[:, 0])
        moments, axes = principal(weight[:, None, None] * (root @ root.transpose(0, 2, 1)))
        return Inertial(weight, self.centre + shift @ self.root.T, moments, axes)


_LAST = [3, 0, 1, 2]  # SciPy's scalar comes last
_FIRST = [1, 2, 3, 0]


def _rotation(quaternions: Array) -> Rotation:
    return Rotation.from_quat(quaternions[:, _FIRST])
