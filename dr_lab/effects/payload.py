"""A mass that somebody attached to a link."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, Scales
from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class Payload(Effect, SpecEdit):
    """A point mass fixed to a moving body, on the line from the body's joint to its centre of mass.

    It is a body of its own (``payload@<body>``, without joint, inertia zero about itself) at
    anchor + distance · e, with e the unit vector, across the joint's axis, from the joint's anchor to the body's
    centre. Where the centre lies on the axis, e is some direction across the axis; without joint the anchor is the
    body's origin. The body is compiled in at every mass.

    Parameters (nominal = absent): mass m ≥ 0 [kg]; distance [m] ≥ 0, which acts only where m > 0 (fits start away from
    absent) and is left out where the body never turns.
    Limits: if the link's mass, centre and inertia are free too, only the sums of m, m·distance and m·distance² over
    link and payload can be told; models that let MuJoCo ignore <inertial> are refused.
    Raises: ModelError if the model's compiler has inertiafromgeom="true".
    Source: parallel-axis theorem; MuJoCo body/inertial.

    Attributes:
        factor: largest m, in units of the body's mass.
        reach: largest distance, in units of the centre's distance (of the radius of gyration, if that is larger).
        start_mass: m of the fits that start away from absent, share of its upper bound.
        start_distances: distances of these fits, shares of the upper bound.
    """

    factor: float
    reach: float
    start_mass: float
    start_distances: tuple[float, ...]

    name: ClassVar[str] = "payload"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "point mass m at a distance from the joint"
    fingerprint: ClassVar[str] = "force residual with both weight and acceleration; frequencies shift"
    confused_with: ClassVar[tuple[str, ...]] = ("armature", "torque_scale")
    argument: ClassVar[str] = "inertia"
    shapes: ClassVar[tuple[str, ...]] = ("distance",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the moving bodies with mass."""
        return tuple(
            model.body(i).name
            for i in range(1, model.nbody)
            if model.body(i).name and model.body_weldid[i] != 0 and model.body_mass[i] > 0
        )

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The mass and, on bodies that turn, the distance."""
        del scales
        body = model.body(site)
        mass = Parameter("mass", "kg", 0.0, 0.0, self.factor * float(body.mass[0]))
        if not _turns(model, body.id):
            return (mass,)
        centre = float(np.linalg.norm(_lever(model, body.id)[1]))
        length = max(centre, float(np.sqrt(body.inertia.max() / body.mass[0])))
        return (mass, Parameter("distance", "m", centre or length, 0.0, self.reach * length))

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Attach the body."""
        if spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
            raise ModelError(
                'A payload needs <inertial>, which inertiafromgeom="true" ignores. Set the compiler\'s inertiafromgeom '
                'to "auto".'
            )
        body = spec.body(site)
        if body is None:
            raise UnknownNameError("body", site, [b.name for b in spec.bodies if b.name], f"model {spec.modelname!r}")
        compiled = spec.copy().compile()
        anchor, lever = _lever(compiled, compiled.body(site).id)
        length = float(np.linalg.norm(lever))
        direction = lever / length if length else _across(compiled, compiled.body(site).id)
        load = body.add_body(name=f"{self.name}@{site}", pos=anchor + values.get("distance", length) * direction)
        load.explicitinertial = True
        load.mass = values["mass"]
        load.ipos, load.iquat, load.inertia = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A small mass at several distances."""
        mass = {"mass": self.start_mass * parameters[0].high}
        return tuple({**mass, **{p.name: share * p.high for p in parameters[1:]}} for share in self.start_distances)


def _turns(model: mujoco.MjModel, body: int) -> bool:
    """Whether any joint between the world and the body lets it turn."""
    while body:
        first = int(model.body_jntadr[body])
        if any(int(kind) != _SLIDE for kind in model.jnt_type[first : first + int(model.body_jntnum[body])]):
            return True
        body = int(model.body_parentid[body])
    return False


def _axis(model: mujoco.MjModel, body: int) -> Array:
    """Axis of the body's last hinge in the body's frame, zero if it has none."""
    first = int(model.body_jntadr[body])
    rows = range(first, first + int(model.body_jntnum[body]))
    hinges = [row for row in rows if int(model.jnt_type[row]) == int(mujoco.mjtJoint.mjJNT_HINGE)]
    return model.jnt_axis[hinges[-1]].copy() if hinges else np.zeros(3)


def _lever(model: mujoco.MjModel, body: int) -> tuple[Array, Array]:
    """Anchor of the body's last joint, and the vector across its hinge's axis from there to the centre of mass."""
    joints = int(model.body_jntnum[body])
    anchor = model.jnt_pos[int(model.body_jntadr[body]) + joints - 1].copy() if joints else np.zeros(3)
    axis, centre = _axis(model, body), model.body_ipos[body] - anchor
    lever = centre - axis * (axis @ centre)
    rounding = np.finfo(float).eps ** 0.5 * max(float(np.linalg.norm(centre)), model.stat.extent)
    return anchor, lever if np.linalg.norm(lever) > rounding else np.zeros(3)


def _across(model: mujoco.MjModel, body: int) -> Array:
    """Unit vector across the body's hinge axis."""
    axis = _axis(model, body)
    across = np.asarray(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]), dtype=float)
    length = float(np.linalg.norm(across))
    return across / length if length else np.array([1.0, 0.0, 0.0])
