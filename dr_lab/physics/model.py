"""A machine's model: MJCF, declared parameters and effects, compiled freshly for any context."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.naming import name_elements
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.target import Target
from dr_lab.trajectory import Array

_KEYS = ("target", "unit", "low", "high")


class ModelEffect(Protocol):
    """What a model asks of a placed effect: its parameters, its edit of a fresh spec and its signal delays."""

    @property
    def label(self) -> str:
        """``effect@site``, unique within a model."""
        ...

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The effect's parameters, nominal = absent."""
        ...

    def edit(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Write the effect into a fresh spec; `values` by parameter name."""
        ...

    def output_delay(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Delay in s of measured channels against the physics, by channel name (absent names: 0)."""
        ...

    def command_delay(self, values: Mapping[str, float], option: mujoco.MjOption) -> Mapping[str, float]:
        """Delay in s that commands need beside the edit, by actuator name (absent: 0)."""
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
    targets: Mapping[str, Target]
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
            return self.spec_at(z).compile()
        except ValueError as error:
            values = ", ".join(f"{n}={v:.6g}" for n, v in self.space.mapping(z).items())
            raise ModelError(f"Model {self.name!r} does not compile at {values}: {error}") from error

    def nominal(self) -> mujoco.MjModel:
        """Compiled model at the nominal context."""
        return self.compile(self.space.nominal)

    def output_delays(self, z: Array) -> dict[str, float]:
        """Delay in s of each delayed channel at context z; delays of several effects add."""
        values = self.space.mapping(z)
        return _total(effect.output_delay(values) for effect in self.effects)

    def command_delays(self, z: Array) -> dict[str, float]:
        """Delay in s of commands that MuJoCo cannot delay by so little, by actuator name."""
        values = self.space.mapping(z)
        return _total(effect.command_delay(values, self.spec.option) for effect in self.effects)


def _total(delays: Iterable[Mapping[str, float]]) -> dict[str, float]:
    """Sum of delays by channel."""
    total: dict[str, float] = {}
    for each in delays:
        for channel, delay in each.items():
            total[channel] = total.get(channel, 0.0) + delay
    return total


def load(name: str, mjcf: str | Path, parameters: Mapping[str, Mapping[str, object]]) -> Model:
    """Read an MJCF file and declare its free parameters.

    Args:
        name: model name.
        mjcf: path of the MJCF file.
        parameters: parameter name → ``target``, ``unit``, ``low``, ``high``; nominal is read from the file.

    Raises:
        ModelError: the file is missing or does not compile (MuJoCo's message is kept), or a parameter changes nothing.
        UnknownNameError: a target names an element or attribute that does not exist.
    """
    path = Path(mjcf)
    if not path.is_file():
        raise ModelError(f"Model {name!r}: there is no MJCF file {str(path)!r}. Set model.mjcf to an existing file.")
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        spec.copy().compile()
    except ValueError as error:
        raise ModelError(f"Model {name!r} does not compile ({path.name}): {error}") from error
    return from_spec(name, spec, parameters)


def from_spec(name: str, spec: mujoco.MjSpec, parameters: Mapping[str, Mapping[str, object]]) -> Model:
    """Declare the free parameters of a spec, whose unnamed elements get names; arguments and errors as `load`."""
    spec = spec.copy()
    name_elements(spec)
    for key, entry in parameters.items():
        _require_known(name, key, entry)
    targets = {key: Target.parse(str(_entry(name, key, entry, "target"))) for key, entry in parameters.items()}
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
    """Check that a parameter changes the compiled model or an output delay between its bounds.

    A bound that does not compile is an infeasible context, which is a change.

    Raises:
        ModelError: it changes nothing.
    """
    space = model.space
    index = space.index(parameter)
    compiled, delays = [], []
    for bound in (space.low[index], space.high[index]):
        z = space.nominal
        z[index] = bound
        compiled.append(_fingerprint(model, z))
        delays.append((model.output_delays(z), model.command_delays(z)))
    if compiled[0] == compiled[1] and delays[0] == delays[1]:
        low, high = space.low[index], space.high[index]
        raise ModelError(
            f"Parameter {parameter!r} of model {model.name!r} changes nothing between {low:g} and {high:g}. "
            "Point its target at something the physics uses, or delete it."
        )


def _fingerprint(model: Model, z: Array) -> bytes:
    """The compiled model's bytes; empty where the context does not compile."""
    try:
        compiled = model.compile(z)
    except ModelError:
        return b""
    buffer = np.zeros(mujoco.mj_sizeModel(compiled), np.uint8)
    mujoco.mj_saveModel(compiled, None, buffer)
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
