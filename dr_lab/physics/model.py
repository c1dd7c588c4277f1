"""A machine's model: MJCF, declared parameters and effects, compiled freshly for any context."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.compiling import compiled
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.inertias import written_out
from dr_lab.physics.law import Law
from dr_lab.physics.naming import name_elements
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.shared_target import SharedTarget, parse
from dr_lab.physics.signal import Reading
from dr_lab.physics.target import Target
from dr_lab.trajectory import Array

_KEYS = ("target", "unit", "low", "high")


class ModelEffect(Protocol):
    """What a model asks of a placed effect: its parameters, its edit of a fresh spec and its signal transforms."""

    @property
    def label(self) -> str:
        """``effect@site``, unique within a model."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The effect's parameters, nominal = absent."""
        ...

    def prepare(self, spec: mujoco.MjSpec) -> None:
        """Write into a fresh spec at its nominal values what the effect needs in every context."""
        ...

    def edit(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Write the effect into a fresh spec; `values` by parameter name."""
        ...

    def reading(self, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """What a sensor reports of a channel; `read` itself where the effect does not touch it.

        Args:
            values: values by parameter name, shape (c, 1, 1).
            channel: the channel's name.
            read: what the sensor would report without the effect.
            begin: s on the log's clock at which the windows start, shape (w, 1).
        """
        ...

    def command(self, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption) -> Array:
        """What becomes of an actuator's commands beside the edit; `series` itself where the effect does not touch them.

        Args:
            values: values by parameter name, shape (c, 1, 1).
            actuator: the actuator's name.
            series: step averages of the commands, the past included, shape (c or 1, w, s).
            option: the model's options, which hold the step.
        """
        ...

    def drivers(self, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """What `command` does, step by step; `values` by name, one for each simulation, shape (n,)."""
        ...

    def force_laws(self, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """What acts from step to step beside the edit.

        Args:
            values: values by name, one for each simulation, shape (n,).
            models: the compiled model of each simulation, with all effects at its context; the layout is the same.
        """
        ...

    def lacking(self, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """What an exported MJCF file lacks of the effect at these values, empty if nothing."""
        ...


@dataclass(frozen=True)
class Model:
    """A MuJoCo model with named free physics.

    Every compilation starts from a fresh copy of the spec at its nominal values, so edits never accumulate.

    Attributes:
        name: model name.
        spec: the nominal spec; never edited.
        declared: the model's own parameters.
        targets: where each declared parameter sits, by name.
        effects: effects that are compiled in, in order of their addition.
    """

    name: str
    spec: mujoco.MjSpec
    declared: tuple[Parameter, ...]
    targets: Mapping[str, Target | SharedTarget]
    effects: tuple[ModelEffect, ...] = ()

    @property
    def space(self) -> ContextSpace:
        """The context of this model: declared parameters, then each effect's."""
        return ContextSpace(self.declared + tuple(p for effect in self.effects for p in effect.parameters))

    def with_effect(self, effect: ModelEffect) -> "Model":
        """This model with one more effect compiled in.

        Raises:
            ModelError: the same effect already sits there.
        """
        if any(effect.label == other.label for other in self.effects):
            raise ModelError(f"Effect {effect.label!r} is already part of model {self.name!r}.")
        return replace(self, effects=(*self.effects, effect))

    def spec_at(self, z: Array) -> mujoco.MjSpec:
        """Fresh spec with the context z written into it; z shape (n,)."""
        values = self.space.mapping(z)
        spec = self.spec.copy()
        for effect in self.effects:
            effect.prepare(spec)
        for parameter in self.declared:
            self.targets[parameter.name].write(spec, values[parameter.name])
        for effect in self.effects:
            effect.edit(spec, values)
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

    def nominal(self) -> mujoco.MjModel:
        """Compiled model at the nominal context."""
        return self.compile(self.space.nominal)

    def reading(self, z: Array, channel: str, read: Reading, begin: Array) -> Reading:
        """What a sensor reports of a channel under contexts z (c, n), by the effects in order; see `ModelEffect`."""
        values = self._columns(z)
        for effect in self.effects:
            read = effect.reading(values, channel, read, begin)
        return read

    def command(self, z: Array, actuator: str, series: Array) -> Array:
        """What becomes of an actuator's commands under contexts z (c, n); see `ModelEffect`."""
        values = self._columns(z)
        for effect in self.effects:
            series = effect.command(values, actuator, series, self.spec.option)
        return series

    def laws(self, z: Array, models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """What acts from step to step in n simulations with contexts z (n, parameters), compiled to `models`."""
        values = {name: z[:, i] for i, name in enumerate(self.space.names)}
        return tuple(law for effect in self.effects for law in effect.force_laws(values, models))

    def _columns(self, z: Array) -> dict[str, Array]:
        return {name: z[:, i, None, None] for i, name in enumerate(self.space.names)}


def load(name: str, mjcf: str | Path, parameters: Mapping[str, Mapping[str, object]] | None) -> Model:
    """Read an MJCF file and declare its free parameters.

    Args:
        name: model name.
        mjcf: path of the MJCF file.
        parameters: parameter name → ``target`` (or a list of them, for a value that several places share), ``unit``,
            ``low``, ``high``; nominal is read from the file. None: every value of the file stands.

    Raises:
        ModelError: the file is missing or does not compile (MuJoCo's message is kept), or a parameter changes nothing.
        UnknownNameError: a target names an element or attribute that does not exist.
    """
    path = Path(mjcf)
    if not path.is_file():
        raise ModelError(f"Model {name!r}: there is no MJCF file {str(path)!r}. Set model.mjcf to an existing file.")
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        compiled(spec.copy())
    except ValueError as error:
        raise ModelError(f"Model {name!r} does not compile ({path.name}): {error}") from error
    return from_spec(name, spec, parameters or {})


def from_spec(name: str, spec: mujoco.MjSpec, parameters: Mapping[str, Mapping[str, object]]) -> Model:
    """Declare the free parameters of a spec, whose unnamed elements get names; arguments and errors as `load`."""
    spec = spec.copy()
    name_elements(spec)
    for key, entry in parameters.items():
        _require_known(name, key, entry)
    targets = {key: parse(_entry(name, key, entry, "target")) for key, entry in parameters.items()}
    spec = written_out(spec, targets.values())
    declared = tuple(
        Parameter(
            name=key,
            unit=str(_entry(name, key, entry, "unit")),
            nominal=targets[key].read(spec),
            low=_number(name, key, entry, "low"),
            high=_number(name, key, entry, "high"),
        )
        for key, entry in parameters.items()
    )
    model = Model(name, spec, declared, targets)
    for parameter in declared:
        require_live(model, parameter.name)
    return model


def require_live(model: Model, parameter: str) -> None:
    """Check that a parameter changes the compiled model between its bounds.

    A bound that does not compile is an infeasible context, which is a change.

    Raises:
        ModelError: it changes nothing.
    """
    space = model.space
    index = space.index(parameter)
    ends = []
    for bound in (space.low[index], space.high[index]):
        z = space.nominal
        z[index] = bound
        ends.append(_fingerprint(model, z))
    if ends[0] == ends[1]:
        low, high = space.low[index], space.high[index]
        raise ModelError(
            f"Parameter {parameter!r} of model {model.name!r} changes nothing between {low:g} and {high:g}. "
            "Point its target at something the physics uses, or delete it."
        )


def _fingerprint(model: Model, z: Array) -> bytes:
    """The compiled model's bytes; empty where the context does not compile."""
    try:
        at_z = model.compile(z)
    except ModelError:
        return b""
    buffer = np.zeros(mujoco.mj_sizeModel(at_z), np.uint8)
    mujoco.mj_saveModel(at_z, None, buffer)
    return buffer.tobytes()


def _require_known(model: str, name: str, entry: Mapping[str, object]) -> None:
    for key in entry:
        if key not in _KEYS:
            raise UnknownNameError("key", str(key), _KEYS, f"parameter {name!r} of model {model!r}")


def _entry(model: str, name: str, entry: Mapping[str, object], key: str) -> object:
    if key not in entry:
        raise ModelError(
            f"Parameter {name!r} of model {model!r} has no {key!r}; given: {', '.join(map(str, entry)) or 'nothing'}. "
            "A parameter needs target, unit, low and high."
        )
    return entry[key]


def _number(model: str, name: str, entry: Mapping[str, object], key: str) -> float:
    value = _entry(model, name, entry, key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ModelError(f"Parameter {name!r} of model {model!r}: {key} = {value!r} is not a number.")
    return float(value)


def joints(model: mujoco.MjModel, kinds: Sequence[mujoco.mjtJoint]) -> tuple[str, ...]:
    """Names of the joints of the given kinds, in the model's order."""
    wanted = {int(k) for k in kinds}
    return tuple(model.joint(i).name for i in range(model.njnt) if int(model.jnt_type[i]) in wanted)
