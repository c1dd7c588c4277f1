"""A machine's model: MJCF, declared parameters and effects, compiled freshly for any context."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import mujoco
import numpy as np

from dr_lab.errors import ModelError
from dr_lab.physics.actuator_attributes import require_ends_apart
from dr_lab.physics.body_contexts import apart
from dr_lab.physics.compiling import compiled
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.derived import Derived
from dr_lab.physics.effect_parts import CommandFilter, ForceLaw, SensorTransform, SpecEdit, SpecPreparation
from dr_lab.physics.entry import number, require_known, value_of
from dr_lab.physics.inertial import KEY, BodyInertial, declare, require_alone
from dr_lab.physics.inertias import written_out
from dr_lab.physics.law import Law
from dr_lab.physics.live_parameter import require_live
from dr_lab.physics.model_effect import ModelEffect
from dr_lab.physics.naming import require_joints_apart
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.settling import settled
from dr_lab.physics.shared_target import SharedTarget, parse, places
from dr_lab.physics.signal import Reading
from dr_lab.physics.target import Target
from dr_lab.trajectory import Array

_Part = TypeVar("_Part")

Declared = str | Mapping[str, object]


@dataclass(frozen=True)
class Model:
    """A MuJoCo model with named free physics.

    Every compilation starts from a fresh copy of the spec at its nominal values, so edits never accumulate.

    Attributes:
        name: model name.
        spec: the nominal spec; never edited.
        declared: the model's own parameters.
        targets: where declared parameters sit, by name; the others only enter what is derived.
        effects: effects that are compiled in, in order of their addition.
        derived: what follows from declared parameters, in the order in which it is written.
        inertials: bodies of which all ten inertial parameters are among the declared ones.
    """

    name: str
    spec: mujoco.MjSpec
    declared: tuple[Parameter, ...]
    targets: Mapping[str, Target | SharedTarget]
    effects: tuple[ModelEffect, ...] = ()
    derived: tuple[Derived, ...] = ()
    inertials: tuple[BodyInertial, ...] = ()

    @cached_property
    def space(self) -> ContextSpace:
        """The context of this model: declared parameters, then each effect's."""
        return ContextSpace(self.declared + tuple(p for effect in self.effects for p in effect.parameters))

    @property
    def places(self) -> tuple[Target | SharedTarget, ...]:
        """Where values are written: those of parameters, then what is derived."""
        return (*(self.targets[name] for name in self._placed), *(each.target for each in self.derived))

    def placed(self, z: Array) -> Array:
        """The values that go to the `places` in contexts z (c, n), shape (c, places)."""
        values = self.values(z)
        direct = [values[name] for name in self._placed]
        derived = [np.broadcast_to(each.formula(values), len(z)) for each in self.derived]
        return np.stack([*direct, *derived], axis=1) if self.places else np.empty((len(z), 0))

    @property
    def _placed(self) -> list[str]:
        """Declared parameters that sit somewhere."""
        return [each.name for each in self.declared if each.name in self.targets]

    def with_effect(self, effect: ModelEffect) -> "Model":
        """This model with one more effect compiled in.

        Raises:
            ModelError: the same effect already sits there.
        """
        if any(effect.label == other.label for other in self.effects):
            raise ModelError(f"Effect {effect.label!r} is already part of model {self.name!r}.")
        return replace(self, effects=(*self.effects, effect))

    def replayed(self) -> "Model":
        """This model as recorded commands are replayed by it; itself where its effects act as they do on others."""
        effects = tuple(effect.replayed(self.spec) for effect in self.effects)
        return self if effects == self.effects else replace(self, effects=effects)

    def having(self, part: type[_Part]) -> Iterator[tuple[ModelEffect, str, _Part]]:
        """The effects that have a part, in order, each with every element that it acts at and with the part."""
        for effect in self.effects:
            if isinstance(effect.effect, part):
                yield from ((effect, element, effect.effect) for element in effect.elements)

    @property
    def lawful(self) -> bool:
        """Whether laws act from step to step."""
        return any(True for _ in self.having(ForceLaw))

    def spec_at(self, z: Array) -> mujoco.MjSpec:
        """Fresh spec with the context z written into it; z shape (n,)."""
        values = self.space.mapping(z)
        spec = self._prepared.copy()
        for place, value in zip(self.places, self.placed(z[None])[0].tolist(), strict=True):
            place.write(spec, value)
        for body in self.inertials:
            body.write(spec, values)
        for effect, element, part in self.having(SpecEdit):
            part.edit(spec, element, effect.local(values))
        return spec

    @cached_property
    def _prepared(self) -> mujoco.MjSpec:
        """The nominal spec with what the effects need in every context."""
        spec = self.spec.copy()
        for _, element, part in self.having(SpecPreparation):
            part.prepare(spec, element)
        return spec

    def compile(self, z: Array) -> mujoco.MjModel:
        """Compiled model at context z.

        Raises:
            ModelError: the context does not compile; MuJoCo's message is kept.
        """
        try:
            return compiled(self.spec_at(z))
        except ValueError as error:
            values = ", ".join(f"{n}={v:.6g}" for n, v in self.space.mapping(z).items())
            raise ModelError(f"Model {self.name!r} does not compile at {values}: {error}") from error

    @cached_property
    def bodies_apart(self) -> bool:
        """Whether the free bodies' inertias can be written into fields of a model that is compiled without them."""
        return bool(self.effects and self.inertials) and apart(self.space, self.inertials, self.compile)

    def nominal(self) -> mujoco.MjModel:
        """Compiled model at the nominal context."""
        return self.compile(self.space.nominal)

    def values(self, z: Array) -> dict[str, Array]:
        """Value of every parameter in the contexts z (c, n) by name, shape (c,)."""
        return {name: z[:, i] for i, name in enumerate(self.space.names)}

    def reading(self, z: Array, channel: str, read: Reading, begin: Array) -> Reading:
        """What a sensor reports of a channel under contexts z (c, n), by the effects in order."""
        values = self._columns(z)
        for effect, element, part in self.having(SensorTransform):
            read = part.reading(element, effect.local(values), channel, read, begin)
        return read

    def command(self, z: Array, actuator: str, series: Array) -> Array:
        """What becomes of an actuator's commands under contexts z (c, n), by the effects in order, shifts last.

        Args:
            z: contexts.
            actuator: the actuator's name.
            series: step averages of its commands, the past included, shape (c or 1, w, s).

        Returns:
            Step averages behind the filters; `series` itself where there is none that changes it.
        """
        values = self._columns(z)
        for effect, element, part in sorted(self.having(CommandFilter), key=lambda each: each[2].memory > 0):
            if element == actuator:
                series = part.filtered(effect.local(values), series, self.spec.option)
        return series

    def laws(self, z: Array, models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """What acts from step to step in n simulations with contexts z (n, parameters), compiled to `models`."""
        values = self.values(z)
        return tuple(part.force_law(at, each.local(values), models) for each, at, part in self.having(ForceLaw))

    def _columns(self, z: Array) -> dict[str, Array]:
        return {name: value[:, None, None] for name, value in self.values(z).items()}


def load(
    name: str,
    mjcf: str | Path,
    parameters: Declared | None,
    derived: Mapping[str, str] | None = None,
) -> Model:
    """Read an MJCF file and declare its free parameters.

    Args:
        name: model name.
        mjcf: path of the MJCF file.
        parameters: parameter name → ``target`` (or a list of them, for a value that several places share), ``unit``,
            ``low``, ``high``; nominal is read from the file. A parameter that only enters what is derived has
            ``nominal`` in place of ``target``. The name ``inertial`` frees all ten inertial parameters of bodies: of
            ``all`` that move, or of those of a list; the word alone in place of the mapping stands for
            ``{inertial: all}``. None: every value of the file stands.
        derived: target → formula of parameters, as ``pole.mass * pole.length**2 / 12``; it replaces the file's value.

    Raises:
        ModelError: the file is missing or does not compile (MuJoCo's message is kept), or a parameter changes nothing.
        UnknownNameError: a target names an element or attribute that does not exist.
        ConfigError: a formula cannot be read, or uses another name.
    """
    path = Path(mjcf)
    if not path.is_file():
        raise ModelError(f"Model {name!r}: there is no MJCF file {str(path)!r}. Set model.mjcf to an existing file.")
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        compiled(spec.copy())
    except ValueError as error:
        raise ModelError(f"Model {name!r} does not compile ({path.name}): {error}") from error
    return from_spec(name, spec, parameters or {}, derived)


def from_spec(
    name: str,
    spec: mujoco.MjSpec,
    parameters: Declared,
    derived: Mapping[str, str] | None = None,
) -> Model:
    """Declare the free parameters of a spec, whose unnamed elements get names; arguments and errors as `load`."""
    spec = settled(spec)
    require_joints_apart(name, spec)
    parameters, bodies = _apart(name, parameters)
    for key, entry in parameters.items():
        require_known(name, key, entry)
    placed = {key: entry for key, entry in parameters.items() if "nominal" not in entry}
    targets = {key: parse(value_of(name, key, entry, "target")) for key, entry in placed.items()}
    follow = tuple(Derived.parse(target, text, tuple(parameters)) for target, text in (derived or {}).items())
    spec = written_out(spec, [*targets.values(), *(each.target for each in follow)])
    for each in follow:
        each.target.read(spec)
    declared = tuple(
        Parameter(
            name=key,
            unit=str(value_of(name, key, entry, "unit")),
            nominal=targets[key].read(spec) if key in targets else number(name, key, entry, "nominal"),
            low=number(name, key, entry, "low"),
            high=number(name, key, entry, "high"),
        )
        for key, entry in parameters.items()
    )
    bounds = {p.name: (p.low, p.high) for p in declared}
    require_ends_apart(spec, {at: bounds[key] for key, target in targets.items() for at in places([target])})
    inertials: tuple[BodyInertial, ...] = ()
    if bodies is not None:
        require_alone(name, [*targets.values(), *(each.target for each in follow)], spec, bodies)
        spec, inertials = declare(spec, bodies)
        declared += tuple(p for body in inertials for p in body.parameters)
    model = Model(name, spec, declared, targets, derived=follow, inertials=inertials)
    for parameter in declared:
        require_live(name, parameter, model.space, model.compile)
    return model


def _apart(name: str, parameters: Declared) -> tuple[dict[str, Mapping[str, object]], object | None]:
    """The parameters' entries, and beside them of which bodies all inertial parameters are free; None for no body."""
    if isinstance(parameters, str):
        parameters = {parameters: "all"}
    entries = {key: entry for key, entry in parameters.items() if isinstance(entry, Mapping) and key != KEY}
    wrong = [key for key in parameters if key not in entries and key != KEY]
    if wrong:
        raise ModelError(
            f"Parameter {wrong[0]!r} of model {name!r} is {parameters[wrong[0]]!r}; expected target, unit, low and "
            f"high, as {{target: body.arm.mass, unit: kg, low: 0.1, high: 1.0}}. Only {KEY!r} stands by itself."
        )
    return entries, parameters.get(KEY)
