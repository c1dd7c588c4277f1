"""A force that the user writes down."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.joint_effect import JointEffect
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.effect_parts import ForceLaw
from dr_lab.physics.expression import Expression
from dr_lab.physics.law import Influence, Law, Moment
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_VARIABLES = ("q", "v", "u", "t")
_KEYS = ("unit", "nominal", "low", "high")


@dataclass(frozen=True)
class Formula(JointEffect, ForceLaw):
    """The user's own force at a joint: an expression of position, velocity, command and time with named parameters.

    tau = f(q, v, u, t; parameters), held through each step at the state in its middle.

    Parameters: the user's. The force must vanish at their nominal values, so the nominal value of a factor is 0.
    Limits: hinge and slide joints; u is the command of the first actuator at the joint, 0 without one; t is in s on the
    log's clock. A stiff formula wants a small step. A value that is not a number counts as a simulation that diverges.

    Attributes:
        expression: f, as ``-k * q * abs(q)``; with + − * / ** and the functions of `expression.FUNCTIONS`.
        free: by name, ``unit``, ``nominal``, ``low``, ``high``.
        start: values of the fits that start away from absent, by name; empty for none.

    Raises:
        ConfigError: the expression cannot be read, or a parameter is not used by it or lacks a bound.
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
            if name in _VARIABLES or name not in read.used:
                raise ConfigError(
                    f"Formula {self.expression!r}: the parameter {name!r} is not in it. Use it, or delete it."
                )
            for key in entry:
                if key not in _KEYS:
                    raise UnknownNameError("key", key, _KEYS, f"parameter {name!r} of the formula")
            missing = [key for key in _KEYS if key not in entry]
            if missing:
                raise ConfigError(f"Formula: the parameter {name!r} has no {', '.join(missing)}.")
        for start in self.start:
            for name in start:
                if name not in self.free:
                    raise UnknownNameError("parameter", name, self.free, "the formula (start)")

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The user's parameters."""
        del model, site, scales
        return tuple(
            Parameter(name, str(e["unit"]), float(e["nominal"]), float(e["low"]), float(e["high"]))
            for name, e in self.free.items()
        )

    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The force of each step."""
        compiled = models[0]
        joint = compiled.joint(site)
        at = np.flatnonzero(
            (compiled.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)) & (compiled.actuator_trnid[:, 0] == joint.id)
        )
        column = int(compiled.actuator_ctrladr[at[0]]) if len(at) and compiled.actuator_ctrlnum[at[0]] else None
        return _Written(int(joint.qposadr[0]), int(joint.dofadr[0]), column, self._read(), values)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """None: the bounds are the user's."""
        del name, kept, margin
        return 0.0

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """The user's starts; parameters that one leaves out are at nominal."""
        del parameters
        return tuple(dict(start) for start in self.start)

    def _read(self) -> Expression:
        return Expression(self.expression, (*_VARIABLES, *self.free))


@dataclass(frozen=True)
class _Written(Law):
    """The formula's force; values of shape (n,)."""

    address: int
    dof: int
    column: int | None
    expression: Expression
    values: Mapping[str, Array]

    def act(self, moment: Moment, influence: Influence) -> None:
        state = {
            "q": moment.qpos[:, self.address],
            "v": moment.qvel[:, self.dof],
            "u": 0.0 if self.column is None else influence.control[:, self.column],
            "t": moment.time,
        }
        influence.force[:, self.dof] += self.expression({**self.values, **state})
