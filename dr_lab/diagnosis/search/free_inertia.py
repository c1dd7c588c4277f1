"""The inertia of a body and of those beyond it, as free as a rigid body's can be."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.diagnosis.search.free_law import FreeLaw
from dr_lab.effects.body_effect import body_of, with_inertial
from dr_lab.errors import ModelError
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_MOMENTS = ("x", "y", "z")
_SQUARES = ("xx", "yy", "zz", "xy", "xz", "yz")
_UPPER = ([0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2])
_LIGHTEST = 1e-6  # of its mass, to which a body can be lightened
_THINNEST = 1e-9  # of all second moments, along the thinnest axis


@dataclass(frozen=True)
class FreeInertia(FreeLaw, SpecPreparation, SpecEdit):
    """The ten inertial parameters of bodies, in which the equations of motion are linear.

    ∫ dm, ∫ r dm and ∫ r rᵀ dm about the body's origin change freely; what no body has is taken back to the nearest
    that one can have (∫ r rᵀ dm about the centre of mass without negative eigenvalues).

    Source: Wensing, Kim and Slotine, IEEE RA-L 3 (2018) 60, section II (second moments, physical consistency).

    Attributes:
        bodies: names of the body at the site and of those that it carries.
    """

    bodies: tuple[str, ...]

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Have the mass matrix stored whole, which MuJoCo spares a body whose centre is its origin."""
        del site
        for name in self.bodies:
            body_of(spec, name).simple = False

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Change the bodies' inertias."""
        del site
        changes = np.array([values[p.name] for p in self.own]).reshape(len(self.bodies), -1)
        for name, change in zip(self.bodies, changes, strict=True):
            if change.any():
                _change(spec, name, change)


def free_inertia(body: str, compiled: mujoco.MjModel) -> FreeInertia:
    """The free law of the inertia of a body and of those beyond it.

    Args:
        body: its name.
        compiled: the compiled nominal model.
    """
    rows, label = list(_beyond(compiled, compiled.body(body).id)), f"free_inertia@{body}"
    mass = float(compiled.body_mass[rows].sum())
    spread = compiled.body_inertia[rows].max(1) / compiled.body_mass[rows]
    length = 2 * float(np.sqrt((spread + (compiled.body_ipos[rows] ** 2).sum(1)).max()))
    kinds = [("mass", "kg", mass)]
    kinds += [(f"moment_{axis}", "kg·m", mass * length) for axis in _MOMENTS]
    kinds += [(f"moment_{axes}", "kg·m²", mass * length**2) for axes in _SQUARES]
    names = tuple(compiled.body(row).name for row in rows)
    own = tuple(Parameter(f"{label}.{n}.{kind}", unit, 0.0, -b, b) for n in names for kind, unit, b in kinds)
    return FreeInertia(label, body, own, own, names)


def _beyond(compiled: mujoco.MjModel, body: int) -> Iterator[int]:
    """A body and the named ones that it carries, those without mass left out."""
    carried = {body}
    for row in range(body, compiled.nbody):
        if row in carried or int(compiled.body_parentid[row]) in carried:
            carried.add(row)
            if compiled.body_mass[row] > 0 and compiled.body(row).name:
                yield row


def _change(spec: mujoco.MjSpec, name: str, change: Array) -> None:
    """Add to mass, first and second moments of a body."""
    body = with_inertial(spec, name)
    mass, centre = float(body.mass), np.asarray(body.ipos, dtype=np.float64)
    about = _about_centre(body.inertia, body.fullinertia, body.iquat, name)
    second = 0.5 * np.trace(about) * np.eye(3) - about + mass * np.outer(centre, centre)
    added = np.zeros((3, 3))
    added[_UPPER] = added[_UPPER[::-1]] = change[4:]
    changed = max(mass + change[0], _LIGHTEST * mass)
    shifted = (mass * centre + change[1:4]) / changed
    values, axes = np.linalg.eigh(second + added - changed * np.outer(shifted, shifted))
    values = np.maximum(values, _THINNEST * values.sum())
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    turned = np.empty(4)
    mujoco.mju_mat2Quat(turned, axes.flatten())
    body.mass, body.ipos, body.iquat = changed, shifted, turned
    body.inertia, body.fullinertia = values.sum() - values, np.full(6, np.nan)


def _about_centre(principal: Array, full: Array, quat: Array, name: str) -> Array:
    """Inertia about the centre of mass in the body's frame, shape (3, 3), from either form that a spec has it in."""
    if np.isfinite(full).all():
        found = np.zeros((3, 3))
        found[_UPPER] = found[_UPPER[::-1]] = full
        return found
    if not np.isfinite(principal).all():
        raise ModelError(f"Body {name!r} has no inertia that could be changed.")
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, np.asarray(quat, dtype=np.float64))
    axes = turn.reshape(3, 3)
    return axes @ np.diag(principal) @ axes.T
