"""What a task gives is held against its contract, so that a mistake in a new task is told where it was made."""

import inspect
from collections.abc import Sequence
from dataclasses import fields

import mujoco
import numpy as np

from dr_lab.envs.slots import Flags
from dr_lab.envs.task import Task
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.trajectory import Array


class ReadFields(dict[str, Array]):
    """Fields by name; one that the task does not name in `reads` is refused with that remedy."""

    def __missing__(self, name: str) -> Array:
        raise UnknownNameError("field", name, self, "`reads` of the task, which has to name each MjData field it takes")


def require_methods(task: Task) -> None:
    """Refuse a task one of whose fields has the name of a method of the contract, which it would hide.

    Raises:
        ConfigError: there is such a field.
    """
    methods = [name for name, each in vars(Task).items() if inspect.isfunction(each) and not name.startswith("_")]
    hidden = [field.name for field in fields(task) if field.name in methods]
    if hidden:
        raise ConfigError(
            f"{_name(task)} has a field {hidden[0]!r}, which hides the method Task.{hidden[0]}; expected a name "
            f"that the contract has not: {', '.join(methods)}. Rename the field, in the task and in its yaml."
        )


def require_start(task: Task, start: tuple[Array, Array], compiled: mujoco.MjModel) -> None:
    """Refuse a start that is not one position and one velocity of the machine.

    Raises:
        ConfigError: a shape differs, or a number is not finite.
    """
    for what, values, size in zip(("positions", "velocities"), start, (compiled.nq, compiled.nv), strict=True):
        if np.shape(values) != (size,):
            raise _other_shape(task, "start", what, np.shape(values), (size,))
        if not np.isfinite(values).all():
            raise ConfigError(f"{_name(task)}.start gives {what} that are not finite: {np.array(values)}.")


def require_observation(task: Task, observation: Array, rows: int) -> None:
    """Refuse an observation that is not one row a simulation.

    Raises:
        ConfigError: its shape differs.
    """
    shape = np.shape(observation)
    if len(shape) != 2 or shape[0] != rows:
        raise _other_shape(task, "observe", "an array", shape, (rows, "o"))


def require_controls(task: Task, controls: Array, action: Array, rows: int, width: int) -> None:
    """Refuse what is not one row of finite commands a simulation, unless the policy asked for what is not finite.

    Raises:
        ConfigError: its shape differs, or a number is not finite.
    """
    if np.shape(controls) != (rows, width):
        raise _other_shape(task, "controls", "an array", np.shape(controls), (rows, width))
    bad = np.flatnonzero(np.isfinite(action).all(axis=1) & ~np.isfinite(controls).all(axis=1))
    if len(bad):
        numbers, asked = (np.array2string(each[bad[0]], precision=4) for each in (controls, action))
        raise ConfigError(f"{_name(task)}.controls gives {numbers} for action {asked}; expected finite numbers.")


def require_outcome(task: Task, reward: Array, terminated: Flags, rows: int) -> None:
    """Refuse what is not one reward and one flag a simulation.

    Raises:
        ConfigError: a shape differs, or the flags are no booleans.
    """
    for method, values in (("reward", reward), ("terminated", terminated)):
        if np.shape(values) != (rows,):
            raise _other_shape(task, method, "an array", np.shape(values), (rows,))
    kind = np.asarray(terminated).dtype
    if not np.issubdtype(kind, np.bool_):
        raise ConfigError(f"{_name(task)}.terminated gives {kind}; expected bool, one a simulation.")


def require_finite(task: Task, reward: Array, observation: Array, qpos: Array, over: Flags) -> None:
    """Refuse numbers that nothing can be learnt from; those of simulations that diverged have been replaced before.

    Args:
        task: the task.
        reward: shape (n,).
        observation: shape (n, o).
        qpos: positions, for the message, shape (n, nq).
        over: episodes that have ended and are stepped on beside the others, shape (n,); nobody asks for their numbers.

    Raises:
        ConfigError: a reward or an observation is not finite.
    """
    for method, values in (("reward", reward[:, None]), ("observe", observation)):
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1) & ~over)
        if len(bad):
            numbers, at = (np.array2string(each[bad[0]], precision=4) for each in (values, qpos))
            raise ConfigError(
                f"{_name(task)}.{method} gives {numbers} at positions {at}; expected finite numbers. Mend the task: a "
                "root or logarithm outside of its range, a division by 0."
            )


def _other_shape(
    task: Task, method: str, what: str, given: Sequence[int], expected: Sequence[int | str]
) -> ConfigError:
    one = {"observe": ", one row a simulation", "controls": ", one row a simulation and one column a command"}
    told = one.get(method, ", one a simulation") if what == "an array" else ""
    return ConfigError(
        f"{_name(task)}.{method} gives {what} of shape {_shape(given)}; expected {_shape(expected)}{told}."
    )


def _shape(sizes: Sequence[int | str]) -> str:
    return f"({', '.join(map(str, sizes))}{',' if len(sizes) == 1 else ''})"


def _name(task: Task) -> str:
    return f"Task {type(task).__name__}"
