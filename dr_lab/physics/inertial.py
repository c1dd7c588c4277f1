"""All ten inertial parameters of a body as one declaration."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated

import mujoco
import numpy as np
from omegaconf import OmegaConf

from dr_lab.bounds import Positive, at_least, require_bounds
from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.compiling import compiled
from dr_lab.physics.inertias import BODY, written_out
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.pseudo_inertia import SHORT, Inertial, LogCholesky
from dr_lab.physics.shared_target import SharedTarget, places
from dr_lab.physics.target import Target
from dr_lab.shipped import shipped
from dr_lab.trajectory import Array

KEY = "inertial"  # in place of a parameter's name
_ALL = "all"
FIELDS = ("body_mass", "body_ipos", "body_iquat", "body_inertia")


@dataclass(frozen=True)
class InertialBounds:
    """How far a body may be from the nominal one; the bounds lie on both sides of 0. Meaning as in `LogCholesky`.

    Attributes:
        mass: largest |ln(m/m₀)|.
        shift: largest move of the centre along each axis, in radii of gyration.
        stretch: largest |d|, in ln of lengths.
        shear: largest |s|.
        prior: standard deviation of the weak prior around the nominal body, in widths of the bounds.

    Raises:
        ConfigError: a number is too small.
    """

    mass: Positive
    shift: Positive
    stretch: Positive
    shear: Positive
    prior: Annotated[float, at_least(1e-3)]

    def __post_init__(self) -> None:
        require_bounds(self, KEY)


@dataclass(frozen=True)
class BodyInertial:
    """The ten numbers of one body in a model.

    Attributes:
        body: its name.
        shape: the nominal body.
        parameters: ten, named ``<body>.inertial.<short name>``, in the order of `SHORT`.
    """

    body: str
    shape: LogCholesky
    parameters: tuple[Parameter, ...]

    def at(self, values: Mapping[str, Array]) -> Inertial:
        """The body in n contexts, given as parameter name → values of shape (n,)."""
        return self.shape.at(np.stack([values[p.name] for p in self.parameters], axis=1))

    def fields(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """The entries of the `FIELDS` of the body in n contexts, by the field's name; arguments as `at`."""
        found = self.at(values)
        return dict(zip(FIELDS, (found.mass, found.centre, found.axes, found.moments), strict=True))

    def write(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Set it in a fresh spec (the caller's copy)."""
        theta = np.array([[values[p.name] for p in self.parameters]])
        found = self.shape.at(theta) if theta.any() else self._nominal
        body = spec.body(self.body)
        body.mass, body.ipos = float(found.mass[0]), found.centre[0]
        body.iquat, body.inertia = found.axes[0], found.moments[0]
        body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT  # the file's euler or axes would win over iquat
        body.fullinertia, body.simple = np.full(6, np.nan), False

    @cached_property
    def _nominal(self) -> Inertial:
        """The body as in the file, whose numbers are all 0. It is compiled again and again where bodies are apart."""
        return self.shape.at(np.zeros((1, len(self.parameters))))


def require_alone(model: str, targets: Iterable[Target | SharedTarget], spec: mujoco.MjSpec, given: object) -> None:
    """Check that no other parameter sits at the mass, centre or inertia of a body that is declared as a whole.

    Raises:
        ModelError: one does.
        UnknownNameError: there is no such body or bound.
    """
    bodies = _names(spec, _asked(given)[0])
    for place in places(targets):
        if place.kind == "body" and place.element in bodies and place.attribute in BODY:
            raise ModelError(
                f"Model {model!r} frees {place} and, by {KEY}, all of the inertia of body {place.element!r}, which "
                f"holds it. Delete the one, or name the other bodies: {KEY}: [the bodies meant]."
            )


def declare(spec: mujoco.MjSpec, given: object) -> tuple[mujoco.MjSpec, tuple[BodyInertial, ...]]:
    """The ten numbers of the bodies that a model's yaml asks for, and the spec with their inertias written out.

    Args:
        spec: the caller's own copy; it may be edited.
        given: ``all``, a list of bodies, or ``bodies`` (either of these) beside bounds that differ from
            ``conf/inertial/default.yaml``.

    Raises:
        ModelError: it is none of these, or a body has no mass or no size.
        UnknownNameError: there is no such body or bound.
        ConfigError: a bound is too small.
    """
    bodies, bounds = _asked(given)
    names = _names(spec, bodies)
    spec = written_out(spec, [Target.parse(f"body.{name}.ipos") for name in names])
    nominal = compiled(spec.copy())
    return spec, tuple(_declared(nominal, name, bounds) for name in names)


def _asked(given: object) -> tuple[object, InertialBounds]:
    entry = {str(key): value for key, value in given.items()} if isinstance(given, Mapping) else {"bodies": given}
    bodies = entry.pop("bodies", _ALL)
    known = {field.name for field in fields(InertialBounds)}
    for key in entry:
        if key not in known:
            raise UnknownNameError("key", key, {"bodies", *known}, KEY)
    usual = OmegaConf.to_container(OmegaConf.load(shipped() / KEY / "default.yaml"))
    numbers = {**usual, **entry} if isinstance(usual, dict) else entry
    return bodies, InertialBounds(**{key: _number(key, numbers[key]) for key in known})


def _number(key: str, value: object) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ModelError(f"{KEY}: {key} is {value!r}, which is not a number.")
    return float(value)


def _names(spec: mujoco.MjSpec, bodies: object) -> list[str]:
    nominal = compiled(spec.copy())
    moving = [
        nominal.body(row).name
        for row in range(1, nominal.nbody)
        if nominal.body_weldid[row] and nominal.body_mass[row] > 0
    ]
    if bodies == _ALL:
        return moving
    if not isinstance(bodies, Sequence) or isinstance(bodies, str) or not bodies:
        raise ModelError(f"inertial: {bodies!r} is neither 'all' nor a list of bodies. Bodies: {', '.join(moving)}.")
    for name in map(str, bodies):
        if name not in moving:
            raise UnknownNameError("moving body with mass", name, moving, f"model {spec.modelname!r}")
    return list(dict.fromkeys(map(str, bodies)))


def _declared(nominal: mujoco.MjModel, name: str, bounds: InertialBounds) -> BodyInertial:
    body = nominal.body(name)
    if not body.inertia.max() > 0:
        raise ModelError(
            f"inertial: body {name!r} has a mass but no size (its inertia is 0). Give it an inertia, or leave it out: "
            "inertial: [the other bodies]."
        )
    given = Inertial(body.mass, body.ipos[None], body.inertia[None], body.iquat[None])
    each = [getattr(bounds, short.partition("_")[0]) for short in SHORT]
    parameters = tuple(
        Parameter(f"{name}.{KEY}.{short}", "1", 0.0, -bound, bound, bounds.prior)
        for short, bound in zip(SHORT, each, strict=True)
    )
    return BodyInertial(name, LogCholesky.of(float(body.mass[0]), body.ipos.copy(), given.tensor[0]), parameters)
