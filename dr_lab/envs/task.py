"""The contract of a task: what the policy sees and does, what is rewarded, and when an episode begins and ends."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Count, require_bounds
from dr_lab.errors import ConfigError, ModelError
from dr_lab.physics.context import ContextSpace, concatenate
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

Fields = Mapping[str, Array]
"""`MjData` fields of n simulations by name, shape (n, …), as MuJoCo leaves them after a step: the state itself is new,
what is derived from it belongs to the integrator's last evaluation."""


Values = Mapping[str, Array]
"""The context of n simulations by parameter, shape (n,) each: what the machine is like, and what the task asks for."""


@dataclass(frozen=True)
class Change:
    """One control step of n simulations.

    Attributes:
        before: the task's marker before the step, shape (n, k).
        after: the marker after it, shape (n, k).
        fields: fields after it.
        values: the context.
        terminated: where the step has ended the episode, shape (n,).
        action: what the policy did, within its bounds, shape (n, a).
        seconds: length of the step.
    """

    before: Array
    after: Array
    fields: Fields
    values: Values
    terminated: NDArray[np.bool_]
    action: Array
    seconds: float

    @property
    def velocity(self) -> Array:
        """Mean velocity of the marker, shape (n, k)."""
        return (self.after - self.before) / self.seconds


@dataclass(frozen=True, kw_only=True)
class Task(ABC):
    """A task, for n simulations at once.

    What its methods give may be parts of the fields themselves, as ``fields["qpos"][:, :1]``; whoever keeps it copies.

    Attributes:
        frame_skip: physics steps per control step.
        time_limit: control steps after which an episode is cut (a truncation, not a termination).
        reads: `MjData` fields that it reads.
        measured: columns of the observation that tell the machine's motion beside its joints, by name, as the place of
            an object; SimOpt compares machine and model by them, too.

    Raises:
        ConfigError: one of them is not at least 1.
    """

    frame_skip: Count
    time_limit: Count
    reads: ClassVar[tuple[str, ...]] = ("qpos", "qvel")
    measured: ClassVar[Mapping[str, int]] = MappingProxyType({})

    def __post_init__(self) -> None:
        require_bounds(self, "env.task")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What the task asks for where that varies, such as a goal or a velocity; nothing unless said otherwise.

        They are part of the context, behind the machine's parameters: randomised, recorded and swept like these.
        """
        return ()

    def goal(self, values: Mapping[str, float]) -> Array | None:
        """Where an episode is to go, in the plane of the first two positions, m, shape (2,).

        Args:
            values: the context of one episode, by parameter.

        Returns:
            None where it is not to go to a place, as unless said otherwise.
        """
        del values
        return None

    def action_bounds(self, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """Lowest and highest action, shape (a,): the actuators' control range, in their unit, unless said otherwise."""
        return compiled.actuator_ctrlrange[:, 0].copy(), compiled.actuator_ctrlrange[:, 1].copy()

    def controls(self, action: Array, values: Values) -> Array:
        """What the actuators are commanded where the policy does `action`: the same unless said otherwise.

        Args:
            action: within its bounds, shape (n, a).
            values: the context.

        Returns:
            In the actuators' unit, shape (n, nu).
        """
        del values
        return action

    @abstractmethod
    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        """Positions (nq,) and velocities (nv,) with which one episode begins."""

    @abstractmethod
    def observe(self, fields: Fields, values: Values) -> Array:
        """What the policy sees, shape (n, o)."""

    def marker(self, fields: Fields) -> Array:
        """What a step's reward has to know of the state before it, shape (n, k); nothing unless said otherwise."""
        return np.empty((len(fields["qpos"]), 0))

    @abstractmethod
    def reward(self, change: Change) -> Array:
        """Reward of one control step, shape (n,)."""

    def solved(self, observation: Array) -> NDArray[np.bool_] | None:
        """Where what is seen, shape (n, o), is what the task is for, shape (n,); None where it names no such thing."""
        del observation
        return None

    def terminated(self, fields: Fields, values: Values) -> NDArray[np.bool_]:
        """Where an episode has come to its end, shape (n,); nowhere unless said otherwise."""
        del values
        return np.zeros(len(fields["qpos"]), bool)


def context_space(model: Model, task: Task) -> ContextSpace:
    """The context: the machine's parameters, then the task's.

    Raises:
        ModelError: both have a parameter of the same name.
    """
    asked = ContextSpace(task.parameters)
    shared = set(model.space.names) & set(asked.names)
    if shared:
        raise ModelError(
            f"Parameters that both model {model.name!r} and task {type(task).__name__} have: "
            f"{', '.join(sorted(shared))}. Rename those of the task."
        )
    return concatenate([model.space, asked])


def required_bounds(task: Task, compiled: mujoco.MjModel) -> tuple[Array, Array]:
    """Lowest and highest action, shape (a,), between which every actuator can do something.

    Raises:
        ModelError: an actuator has no such range, as one without ``ctrlrange``.
        ConfigError: the task's own bounds are not as many highest as lowest ones.
    """
    low, high = (np.array(bound, dtype=float) for bound in task.action_bounds(compiled))
    if low.ndim != 1 or low.shape != high.shape:
        raise ConfigError(
            f"Task {type(task).__name__}.action_bounds gives arrays of shapes {low.shape} and {high.shape}; expected "
            "one lowest and one highest number for each action, (a,) and (a,)."
        )
    fixed = np.flatnonzero(~((low < high) & np.isfinite(high - low)))
    if len(fixed):
        own = type(task).action_bounds is not Task.action_bounds
        names = [f"action {i}" if own else compiled.actuator(int(i)).name or i for i in fixed]
        given = ", ".join(f"{name} [{low[i]:g}, {high[i]:g}]" for name, i in zip(names, fixed, strict=True))
        remedy = (
            f"Mend action_bounds of {type(task).__name__}, or the numbers of env.task that it takes"
            if own
            else "Give them a ctrlrange in the model's XML, in the actuators' unit"
        )
        raise ModelError(
            f"Actuators without a range that a policy could act in: {given}; expected lowest < highest. {remedy}."
        )
    return low, high


def within(values: Array, bounds: Sequence[float]) -> NDArray[np.bool_]:
    """Where low < value < high."""
    return (bounds[0] < values) & (values < bounds[1])
