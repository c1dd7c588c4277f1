"""A mass that somebody attached to a link."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.body_effect import moving_bodies
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.load_frame import lever_of, link_length, load_frame, loaded, mounted
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter

_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class Payload(Effect, SpecPreparation, SpecEdit):
    """A point mass fixed to a moving body, on the line from the body's joint to its centre of mass.

    It is a body of its own (``payload@<body>``, without joint, inertia zero about itself) at
    anchor + distance · e, with e the unit vector, across the joint's axis, from the joint's anchor to the body's
    centre as the model file has it. Where the centre lies on the axis, e is some direction across the axis; without
    joint the anchor is the body's origin. The body is compiled in at every mass.

    Parameters (nominal = absent): mass m ≥ 0 [kg]; distance [m] ≥ 0, which acts only where m > 0 (fits start away from
    absent) and is left out where the body never turns.
    Limits: if the link's mass, centre and inertia are free too, only the sums of m, m·distance and m·distance² over
    link and payload can be told, unless the measurements name which logs were recorded with the load (`loaded`);
    models that let MuJoCo ignore <inertial> are refused.
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
    attached: ClassVar[bool] = True
    shapes: ClassVar[tuple[str, ...]] = ("distance",)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the moving bodies with mass."""
        return moving_bodies(model)

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The mass and, on bodies that turn, the distance."""
        del scales
        body = model.body(site)
        mass = Parameter("mass", "kg", 0.0, 0.0, self.factor * float(body.mass[0]))
        if not _turns(model, body.id):
            return (mass,)
        centre = float(np.linalg.norm(lever_of(model, body.id)[1]))
        length = link_length(model, body.id)
        return (mass, Parameter("distance", "m", centre or length, 0.0, self.reach * length))

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Attach the body without mass."""
        loaded(spec, site)
        compiled = spec.copy().compile()
        anchor, axes, length = load_frame(compiled, compiled.body(site).id)
        mounted(spec, site, f"{self.name}@{site}", anchor, axes)
        spec.body(f"{self.name}@{site}").ipos = [length, 0.0, 0.0]

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Give it its mass and place."""
        load = spec.body(f"{self.name}@{site}")
        load.mass = values["mass"]
        if "distance" in values:
            load.ipos = [values["distance"], 0.0, 0.0]

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
