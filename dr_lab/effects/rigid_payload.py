"""A body of any shape that somebody attached to a link."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import mujoco
import numpy as np

from dr_lab.effects.body_effect import moving_bodies
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.felt_inertia import felt
from dr_lab.effects.load_frame import become, link_length, load_frame, loaded, mounted
from dr_lab.effects.special_case import SpecialCase
from dr_lab.errors import UnknownNameError
from dr_lab.physics.effect_parts import AddedBody, SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.pseudo_inertia import Rooted
from dr_lab.trajectory import Array

_PLACE = ("distance", "side", "along")
_SPREAD = ("spread_x", "spread_y", "spread_z")
_SKEW = ("skew_xy", "skew_yz", "skew_xz")
_ROOT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # where spreads and skews stand in R
_FURTHER = (*_PLACE[1:], *_SPREAD, *_SKEW)


class _Mount(NamedTuple):
    """Where a load sits on a body.

    Attributes:
        body: its row.
        origin: from which places count, in the body's frame.
        axes: along which they count, as columns in the body's frame.
        nominal: place of the link's own centre along the first.
        length: of the link.
    """

    body: int
    origin: Array
    axes: Array
    nominal: float
    length: float


@dataclass(frozen=True)
class RigidPayload(Effect, AddedBody, SpecPreparation, SpecEdit):
    """A rigid body fixed to a moving one: ten inertial parameters, all of which a body can have.

    It is a body of its own (``rigid_payload@<site>``, without joint) whose centre is at anchor + distance e₁ + side e₂
    + along e₃. e₁ leads from the joint's anchor across its axis to the link's centre of mass as the model file has it,
    e₃ is the joint's axis, e₂ = e₃ × e₁; at a MuJoCo <site> of `flanges` the anchor and the axes are the site's. Its
    second moments about its centre are m R Rᵀ with R upper triangular, the spreads on its diagonal and the skews above,
    in the axes e₁, e₂, e₃; so they are positive for every value, and a body of mass m can have them. All spreads and
    skews 0: a point mass.

    Parameters (nominal = absent): mass m ≥ 0 [kg]; distance, side, along [m]; spread_x, _y, _z ≥ 0 and skew_xy, _yz,
    _xz [m], radii of gyration. All but the mass act only where m > 0 (fits start away from absent).
    Limits: sites where the joints feel each of the ten, as from the third joint of an arm on; elsewhere
    `planar_payload` or `payload`. If the link's own inertia is free too, only sums over link and payload can be told,
    and the priors share them out: at a Panda's flange, whose links are known to 20 %, the mass is then told to 0.3 kg.
    It is told by itself where the measurements name which logs were recorded with the load (`loaded`) and others are
    there.
    Raises: ModelError if the model's compiler has inertiafromgeom="true"; UnknownNameError if there is no such flange.
    Source: Newton–Euler equations; Wensing, Kim and Slotine, IEEE RA-L 3 (2018) 60 (second moments); MuJoCo
    body/inertial.

    Attributes:
        factor: largest m, in units of all mass that moves.
        reach: largest distance, side and along, in units of the link's length: of its centre's distance, or of its
            radius of gyration if that is larger.
        spread: largest spread and skew, in the same unit.
        flanges: names of <site>s of moving bodies at which it may sit as well.
        start_mass: m of the fits that start away from absent, share of its upper bound.
        start_distances: distances of these fits, shares of the upper bound.
        start_spread: spreads of these fits, share of the upper bound.
        sensitive: the ten count as felt if the weakest combination of them is above this share of the strongest.
        poses: number of states in which that is looked for.
    """

    factor: float
    reach: float
    spread: float
    flanges: tuple[str, ...]
    start_mass: float
    start_distances: tuple[float, ...]
    start_spread: float
    sensitive: float
    poses: int

    name: ClassVar[str] = "rigid_payload"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "rigid body: mass, centre and inertia added to a link"
    fingerprint: ClassVar[str] = "force residual with both weight and acceleration at several joints at once"
    confused_with: ClassVar[tuple[str, ...]] = ("payload", "centre_of_mass_offset", "inertia_error", "torque_scale")
    holds: ClassVar[Mapping[str, SpecialCase]] = {
        "payload": SpecialCase(_FURTHER, {"mass": "mass", "distance": "distance"})
    }
    argument: ClassVar[str] = "inertia"
    attached: ClassVar[bool] = True
    shapes: ClassVar[tuple[str, ...]] = (*_PLACE, *_SPREAD, *_SKEW)

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the bodies whose load the joints feel in all its ten parameters, then those of the flanges."""
        known = [model.site(row).name for row in range(model.nsite) if model.body_weldid[model.site_bodyid[row]]]
        for name in self.flanges:
            if name not in known:
                raise UnknownNameError("site of a moving body", name, known, "the model (rigid_payload.flanges)")
        return (
            *(name for name in moving_bodies(model) if felt(model, name, self.poses, self.sensitive)),
            *self.flanges,
        )

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The ten."""
        del scales
        mount = self._mount(model, site)
        mass = float(model.body_mass[model.body_weldid != 0].sum())
        reach, spread = self.reach * mount.length, self.spread * mount.length
        places = [Parameter(name, "m", 0.0, -reach, reach) for name in _PLACE[1:]]
        return (
            Parameter("mass", "kg", 0.0, 0.0, self.factor * mass),
            Parameter("distance", "m", mount.nominal, -reach, reach),
            *places,
            *(Parameter(name, "m", 0.0, 0.0, spread) for name in _SPREAD),
            *(Parameter(name, "m", 0.0, -spread, spread) for name in _SKEW),
        )

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Attach the body without mass."""
        if site not in self.flanges:
            loaded(spec, site)
        model = spec.copy().compile()
        mount = self._mount(model, site)
        mounted(spec, model.body(mount.body).name, f"{self.name}@{site}", mount.origin, mount.axes)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Give it its mass, place and inertia."""
        body = self.added({name: np.array([value]) for name, value in values.items()})
        become(spec, f"{self.name}@{site}", body)

    def added(self, values: Mapping[str, Array]) -> Rooted:
        """The bodies at n values each."""
        mass = values["mass"]
        root = np.zeros((len(mass), 3, 3))
        for place, name in zip(_ROOT, (*_SPREAD, *_SKEW), strict=True):
            root[:, *place] = values[name]
        return Rooted(mass, np.stack([values[name] for name in _PLACE], axis=1), root)

    def values_of(self, body: Rooted) -> dict[str, Array]:
        """Their values."""
        places = dict(zip(_PLACE, body.centre.T, strict=True))
        roots = {name: body.root[:, *place] for place, name in zip(_ROOT, (*_SPREAD, *_SKEW), strict=True)}
        return {"mass": body.mass, **places, **roots}

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """A small body at several distances."""
        high = {p.name: p.high for p in parameters}
        own = {"mass": self.start_mass * high["mass"]} | {name: self.start_spread * high[name] for name in _SPREAD}
        return tuple({**own, "distance": share * high["distance"]} for share in self.start_distances)

    def _mount(self, model: mujoco.MjModel, site: str) -> _Mount:
        at_flange = site in self.flanges
        body = int(model.site(site).bodyid[0]) if at_flange else int(model.body(site).id)
        origin, axes, centre = load_frame(model, body)
        length = link_length(model, body)
        if not at_flange:
            return _Mount(body, origin, axes, centre, length)
        turned = np.zeros(9)
        mujoco.mju_quat2Mat(turned, model.site(site).quat)
        return _Mount(body, model.site(site).pos.copy(), turned.reshape(3, 3), 0.0, length or float(model.stat.extent))
