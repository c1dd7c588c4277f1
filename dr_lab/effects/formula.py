"""A force that the user writes down."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import SCALAR, JointEffect, drives
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.expression import Expression, dotted_names, spelt
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.naming import joints
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_VARIABLES = ("q", "v", "u", "t")
_OTHERS = (".q", ".v", ".u")  # position, velocity of a joint and command of an actuator that goes before the dot
_NUMBERS = ("nominal", "low", "high")
_KEYS = ("unit", *_NUMBERS)


@dataclass(frozen=True)
class Formula(JointEffect, ForceLaw):
    """The user's own force at a joint: an expression of position, velocity, command and time with named parameters.

    tau = f(q, v, u, t; parameters), held through each step at the state in its middle. ``pole.q`` and ``pole.v`` are
    position and velocity of a joint that is called pole, ``motor.u`` the command of an actuator that is called motor;
    what Python cannot have in a name is written ``_``. `dr_lab.cli.found_formula` takes the formula that a run's report
    has of the force that is still missing.

    Parameters: the user's. The force must vanish at their nominal values, so the nominal value of a factor is 0.
    Limits: hinge and slide joints; u is the command of the first actuator at the joint, 0 without one; t is in s on the
    log's clock. A stiff formula wants a small step. A value that is not a number counts as a simulation that diverges.

    Attributes:
        expression: f, as ``-k * q * abs(q)``; with + − * / ** and the functions of `expression.FUNCTIONS`.
        free: by name, ``unit``, ``nominal``, ``low``, ``high``.
        start: values of the fits that start away from absent, by name; empty for none.

    Raises:
        ConfigError: the expression cannot be read, or a parameter is not used by it, is called as a variable, or lacks
            a bound.
        UnknownNameError: a parameter has a key that does not exist, or a start names another parameter.
    """

    expression: str
    free: Mapping[str, Mapping[str, float | str]]
    start: Sequence[Mapping[str, float]] = ()

    name: ClassVar[str] = "formula"
    family: ClassVar[str] = "open"
    law: ClassVar[str] = "tau = f(q, v, u, t)"
    fingerprint: ClassVar[str] = "what the user knows of the machine and the catalogue does not"
    lacks: ClassVar[str] = "the force that the formula gives from step to step"

    def __post_init__(self) -> None:
        read = self._read()
        for name, entry in self.free.items():
            if name in _VARIABLES:
                raise ConfigError(
                    f"Formula {self.expression!r}: {name!r} cannot be a parameter, for {', '.join(_VARIABLES)} are the "
                    "joint's position and velocity, the command and the time. Give the parameter another name."
                )
            if name not in read.used:
                raise ConfigError(
                    f"Formula {self.expression!r}: the parameter {name!r} is not in it. Use it, or delete it."
                )
            _require_whole(name, entry)
        for start in self.start:
            for name in start:
                if name not in self.free:
                    raise UnknownNameError("parameter", name, self.free, "the formula (start)")

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The user's parameters.

        Raises:
            UnknownNameError: the formula names a joint or an actuator that the model lacks.
        """
        del site, scales
        known = _sources(model)
        for name in self._others():
            if name not in known:
                raise UnknownNameError("name", name, known, f"formula {self.expression!r}")
        return tuple(
            Parameter(name, str(e["unit"]), float(e["nominal"]), float(e["low"]), float(e["high"]))
            for name, e in self.free.items()
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        compiled, read = models[0], self._read()
        joint, known = compiled.joint(site), _sources(models[0])
        own = np.flatnonzero(drives(compiled, site) & (compiled.actuator_ctrlnum > 0))
        sources = {"q": _Source("qpos", int(joint.qposadr[0])), "v": _Source("qvel", int(joint.dofadr[0]))}
        if len(own):
            sources["u"] = _Source("control", int(compiled.actuator_ctrladr[own[0]]))
        sources |= {name: known[name] for name in self._others()}
        return _Written(int(joint.dofadr[0]), sources, read, values)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """None: the bounds are the user's."""
        del name, kept, margin
        return 0.0

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """The user's starts; parameters that one leaves out are at nominal."""
        del parameters
        return tuple(dict(start) for start in self.start)

    def _read(self) -> Expression:
        return Expression(self.expression, (*_VARIABLES, *self.free, *self._others()))

    def _others(self) -> tuple[str, ...]:
        """Variables of named joints and actuators."""
        return tuple(name for name in dotted_names(self.expression) if name.endswith(_OTHERS))


def _require_whole(name: str, entry: Mapping[str, float | str]) -> None:
    """Check that a parameter's entry has all of its keys, none beside them, and numbers where numbers belong."""
    for key in entry:
        if key not in _KEYS:
            raise UnknownNameError("key", key, _KEYS, f"parameter {name!r} of the formula")
    missing = [key for key in _KEYS if key not in entry]
    if missing:
        raise ConfigError(f"Formula: the parameter {name!r} has no {', '.join(missing)}.")
    for key in _NUMBERS:
        if not isinstance(entry[key], int | float) or isinstance(entry[key], bool):
            raise ConfigError(f"Formula: {key} of the parameter {name!r} is {entry[key]!r}; expected a number.")


class _Source(NamedTuple):
    """Where a variable is read: the array, and the column of it."""

    array: str
    column: int


def _sources(model: mujoco.MjModel) -> dict[str, _Source]:
    """Positions and velocities of the hinge and slide joints and commands of the actuators, as formulas spell them."""
    found: dict[str, _Source] = {}
    for name in joints(model, SCALAR):
        joint = model.joint(name)
        found[f"{spelt(name)}.q"] = _Source("qpos", int(joint.qposadr[0]))
        found[f"{spelt(name)}.v"] = _Source("qvel", int(joint.dofadr[0]))
    for k in np.flatnonzero(model.actuator_ctrlnum > 0):
        found[f"{spelt(model.actuator(k).name)}.u"] = _Source("control", int(model.actuator_ctrladr[k]))
    return found


@dataclass(frozen=True)
class _Written(Law):
    """The formula's force; values of shape (n,). A variable without a source is 0: a command without an actuator."""

    dof: int
    sources: Mapping[str, _Source]
    expression: Expression
    values: Mapping[str, Array]

    def act(self, moment: Moment, influence: Influence) -> None:
        arrays = {"qpos": moment.qpos, "qvel": moment.qvel, "control": influence.control}
        state = {name: arrays[source.array][:, source.column] for name, source in self.sources.items()}
        influence.force[:, self.dof] += self.expression({**self.values, "u": 0.0, "t": moment.time, **state})
