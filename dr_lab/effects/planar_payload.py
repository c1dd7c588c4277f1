"""A body of any shape that somebody attached to a link of a planar mechanism."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.body_effect import moving_bodies
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.felt_inertia import felt, felt_in_plane
from dr_lab.effects.load_frame import become, hinge_axis, link_length, load_frame, loaded, mounted
from dr_lab.effects.special_case import SpecialCase
from dr_lab.physics.effect_parts import AddedBody, SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.pseudo_inertia import Rooted
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class PlanarPayload(Effect, AddedBody, SpecPreparation, SpecEdit):
    """A rigid body fixed to a link, as a mechanism feels it that moves in a plane: four inertial parameters.

    It is a body of its own (``planar_payload@<body>``, without joint) whose centre is at anchor + distance e₁ + side
    e₂. e₁ leads from the joint's anchor across its axis to the link's centre of mass as the model file has it, e₃ is
    the joint's axis, e₂ = e₃ × e₁; where the link's centre lies on the axis, e₁ is some direction across it. About its
    own centre the body is a rod along e₁ with the inertia m · spread² about e₃.

    Parameters (nominal = absent): mass m ≥ 0 [kg]; distance, side [m]; spread ≥ 0 [m], the radius of gyration about e₃.
    All but the mass act only where m > 0 (fits start away from absent).
    Limits: links with a hinge where the joints feel each of the four, but not all ten of a rigid body, as in a planar
    arm or a SCARA from the second hinge on; elsewhere `payload` or `rigid_payload`. If the link's own inertia is free
    too, only sums over link and payload can be told, unless the measurements name which logs were recorded with the
    load (`loaded`).
    Raises: ModelError if the model's compiler has inertiafromgeom="true".
    Source: Newton–Euler equations of planar motion; MuJoCo body/inertial.

    Attributes:
        factor: largest m, in units of all mass that moves.
        reach: largest distance and side, in units of the link's length: of its centre's distance, or of its radius of
            gyration if that is larger.
        spread: largest spread, in the same unit.
        start_mass: m of the fits that start away from absent, share of its upper bound.
        start_distances: distances of these fits, shares of the upper bound.
        start_spread: spread of these fits, share of the upper bound.
        sensitive: parameters count as felt if the weakest combination of them is above this share of the strongest.
        poses: number of states in which that is looked for.
    """

    factor: float
    reach: float
    spread: float
    start_mass: float
    start_distances: tuple[float, ...]
    start_spread: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "planar_payload"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "rigid body in the plane: mass, centre and inertia added to a link"
    fingerprint: ClassVar[str] = "force residual with both weight and acceleration at several joints at once"
    confused_with: ClassVar[tuple[str, ...]] = ("payload", "centre_of_mass_offset", "inertia_error", "torque_scale")
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "payload": SpecialCase(("side", "spread"), {"mass": "mass", "distance": "distance"})
    }
    argument: ClassVar[str] = "inertia"
    attached: ClassVar[bool] = True
    shapes: ClassVar[tuple[str, ...]] = ("distance", "side", "spread")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the links with a hinge whose load the joints feel in the plane, but not in all of its ten."""
        asked = self.poses, self.sensitive
        return tuple(
            name
            for name in moving_bodies(model)
            if hinge_axis(model, model.body(name).id).any()
            and felt_in_plane(model, name, *asked)
            and not felt(model, name, *asked)
        )

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The four."""
        del scales
        body = int(model.body(site).id)
        centre, length = load_frame(model, body)[2], link_length(model, body)
        mass, reach = float(model.body_mass[model.body_weldid != 0].sum()), self.reach * length
        return (
            Parameter("mass", "kg", 0.0, 0.0, self.factor * mass),
            Parameter("distance", "m", centre, -reach, reach),
            Parameter("side", "m", 0.0, -reach, reach),
            Parameter("spread", "m", 0.0, 0.0, self.spread * length),
        )

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Attach the body without mass."""
        loaded(spec, site)
        model = spec.copy().compile()
        origin, axes, _ = load_frame(model, int(model.body(site).id))
        mounted(spec, site, f"{self.name}@{site}", origin, axes)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Give it its mass, place and inertia."""
        body = self.added({name: np.array([value]) for name, value in values.items()})
        become(spec, f"{self.name}@{site}", body)

    def added(self, values: Mapping[str, Array]) -> Rooted:
        """The bodies at n values each."""
        mass, root = values["mass"], np.zeros((len(values["mass"]), 3, 3))
        root[:, 0, 0] = values["spread"]
        return Rooted(mass, np.stack([values["distance"], values["side"], np.zeros_like(mass)], axis=1), root)

    def values_of(self, body: Rooted) -> dict[str, Array]:
        """Their values; what a body is like along the axis is left out."""
        distance, side, _ = body.centre.T
        spread = np.linalg.norm(body.root[:, :2, :], axis=(1, 2))
        return {"mass": body.mass, "distance": distance, "side": side, "spread": spread}

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A small body at several distances."""
        high = {p.name: p.high for p in parameters}
        own = {"mass": self.start_mass * high["mass"], "spread": self.start_spread * high["spread"]}
        return tuple({**own, "distance": share * high["distance"]} for share in self.start_distances)
