"""A link's centre of mass that does not lie where the model says."""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.body_effect import body_of, moving_bodies, with_inertial
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.generalised_forces import inverse_forces
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class CentreOfMassOffset(Effect, SpecPreparation, SpecEdit):
    """The centre of mass of a link lies elsewhere: cables, screws and bearings that the drawing leaves out.

    c → c + (x, y, z) in the body's frame. Mass and inertia about the centre stay; about a joint's axis at the distance
    r the inertia m r² changes with r (Steiner). Inertias that follow from geoms are written out as <inertial>.

    Parameters (nominal = absent): x, y, z [m]; each only where it changes a generalised force of the model to first
    order (a pendulum does not feel its centre move along its hinge).
    Limits: moving bodies with mass; not separable from the link's mass where only weight and inertia about one joint
    are felt; models that let MuJoCo ignore <inertial> are refused.
    Raises: ModelError if the model's compiler has inertiafromgeom="true".
    Source: parallel-axis theorem; MuJoCo body/inertial.

    Attributes:
        factor: bound of each offset, in units of the body's largest radius of gyration about its centre.
        sensitive: a direction counts as felt above this share of the force that an equally large offset has in any.
        poses: number of states in which that is looked for.
    """

    factor: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "centre_of_mass_offset"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "c -> c + (x, y, z)"
    fingerprint: ClassVar[str] = "force residual that turns with the link like its weight; swings about another centre"
    confused_with: ClassVar[tuple[str, ...]] = ("payload", "base_tilt", "inertia_error", "spring")
    argument: ClassVar[str] = "inertia"

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the moving bodies with mass whose centre matters."""
        return tuple(name for name in moving_bodies(model) if self._felt(model, name))

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The offsets that are felt."""
        del scales
        bound = self.factor * _radius(model, site)
        return tuple(Parameter(axis, "m", 0.0, -bound, bound) for axis in self._felt(model, site))

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Have the body's mass matrix stored whole, which MuJoCo spares a body whose centre is its origin."""
        body_of(spec, site).simple = False

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Move the centre of mass."""
        offset = np.array([values.get(axis, 0.0) for axis in _AXES])
        if offset.any():
            body = with_inertial(spec, site)
            body.ipos = np.asarray(body.ipos) + offset

    def _felt(self, model: mujoco.MjModel, site: str) -> tuple[str, ...]:
        """Axes along which a small offset changes a generalised force in some state."""
        body, length = model.body(site).id, _radius(model, site)
        directions = zip(_AXES, length * np.eye(3), strict=True)
        shifted = {axis: _shifted(model, body, offset, self.poses) for axis, offset in directions}
        most = max(np.abs(forces).max(initial=0.0) for forces in shifted.values())
        return tuple(
            axis for axis, (up, down) in shifted.items() if np.abs(up - down).max(initial=0.0) > self.sensitive * most
        )


def _radius(model: mujoco.MjModel, site: str) -> float:
    """Largest radius of gyration of a body about its centre; the machine's size for a point mass."""
    body = model.body(site)
    return float(np.sqrt(body.inertia.max() / body.mass[0])) or float(model.stat.extent)


def _shifted(model: mujoco.MjModel, body: int, offset: Array, poses: int) -> Array:
    """Generalised forces with the centre moved by plus and by minus an offset, shape (2, poses, nv).

    They are quadratic in the offset, so half of the difference is exactly the first order.
    """
    forces = []
    for sign in (1.0, -1.0):
        moved = copy(model)
        moved.body_sameframe[body] = 0  # otherwise MuJoCo takes a centre at the body's origin for granted
        moved.body_ipos[body] += sign * offset
        forces.append(inverse_forces(moved, poses))
    return np.array(forces)
