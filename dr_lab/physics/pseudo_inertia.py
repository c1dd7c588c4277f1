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
_POINT = 1e-12  # m², above which a second moment over the mass is no rounding


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


@dataclass(frozen=True)
class Rooted:
    """n bodies by a root of their second moments, from which no body follows that cannot exist.

    Attributes:
        mass: at least 0, shape (n,), kg.
        centre: of mass in some frame, shape (n, 3), m.
        root: R, upper triangular, shape (n, 3, 3), m; the second moments about the centre are m R Rᵀ.
    """

    mass: Array
    centre: Array
    root: Array

    @property
    def second(self) -> Array:
        """Second moments about the centre, shape (n, 3, 3), kg·m²."""
        return self.mass[:, None, None] * (self.root @ self.root.transpose(0, 2, 1))

    @property
    def pseudo(self) -> Array:
        """Pseudo-inertia [[Σ + m c cᵀ, m c], [m cᵀ, m]], in which equations of motion are linear, shape (n, 4, 4)."""
        columns = np.zeros((len(self.mass), 4, 4))
        columns[:, :3, :3], columns[:, :3, 3], columns[:, 3, 3] = self.root, self.centre, 1.0
        return self.mass[:, None, None] * (columns @ columns.transpose(0, 2, 1))

    @classmethod
    def of(cls, pseudo: Array) -> "Rooted | None":
        """The body of a pseudo-inertia, shape (4, 4); None where no body with a mass and a size has it."""
        found = _parts(pseudo)
        if found is None or found[2][0] <= _THIN * found[2][-1]:
            return None
        mass, centre, values, axes = found
        return cls(np.array([mass]), centre[None], upper_root((axes * values) @ axes.T)[None])

    @classmethod
    def nearest(cls, pseudo: Array) -> "Rooted | None":
        """The same, with second moments that no body has taken to the nearest that one can have; None without mass."""
        found = _parts(pseudo)
        if found is None:
            return None
        mass, centre, values, axes = found
        thick = np.maximum(values, _THIN * max(values[-1], float(centre @ centre), _POINT))
        return cls(np.array([mass]), centre[None], upper_root((axes * thick) @ axes.T)[None])


def _parts(pseudo: Array) -> tuple[float, Array, Array, Array] | None:
    """Mass, centre, and second moments over the mass with their axes; None without mass."""
    mass = float(pseudo[3, 3])
    if not mass > 0:
        return None
    centre = pseudo[:3, 3] / mass
    values, axes = np.linalg.eigh(pseudo[:3, :3] / mass - np.outer(centre, centre))
    return mass, centre, values, axes


def upper_root(matrix: Array) -> Array:
    """R, upper triangular, with R Rᵀ a positive definite matrix of shape (3, 3)."""
    flip = np.eye(3)[::-1]
    return flip @ np.linalg.cholesky(flip @ matrix @ flip) @ flip


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
        return cls(mass, centre, upper_root((axes * thick) @ axes.T))

    def at(self, theta: Array) -> Inertial:
        """The bodies at ten numbers each, in the order of `SHORT`; shape (n, 10)."""
        body = self.rooted(theta)
        moments, axes = principal(body.second)
        return Inertial(body.mass, body.centre, moments, axes)

    def rooted(self, theta: Array) -> Rooted:
        """The same bodies by a root of their second moments."""
        mass, shift, stretch, shear = np.split(theta, (1, 4, 7), axis=1)
        deformed = np.zeros((len(theta), 3, 3))
        deformed[:, range(3), range(3)] = np.exp(stretch)
        for column, place in enumerate(_SHEARS):
            deformed[:, *place] = shear[:, column]
        return Rooted(self.mass * np.exp(mass[:, 0]), self.centre + shift @ self.root.T, self.root @ deformed)

    def numbers(self, body: Rooted) -> Array:
        """The ten numbers of bodies with a mass and a size, shape (n, 10)."""
        deformed, shift = (
            np.linalg.solve(self.root, body.root),
            np.linalg.solve(self.root, (body.centre - self.centre).T),
        )
        stretch = np.log(np.diagonal(deformed, axis1=1, axis2=2))
        shear = np.stack([deformed[:, *place] for place in _SHEARS], axis=1)
        mass = np.log(body.mass / self.mass)
        return np.concatenate([mass[:, None], shift.T, stretch, shear], axis=1, dtype=np.float64)


_LAST = [3, 0, 1, 2]  # SciPy's scalar comes last
_FIRST = [1, 2, 3, 0]


def _rotation(quaternions: Array) -> Rotation:
    return Rotation.from_quat(quaternions[:, _FIRST])
