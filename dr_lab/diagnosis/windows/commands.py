"""Commands as controls of simulation steps: held, or straight from sample to sample."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import UnknownNameError
from dr_lab.trajectory import Array, Log, Signal

_ROUNDING = 1e-6  # steps; a sample on the edge of a step belongs to the step that begins there


def steps_at(time: Array, step: float, count: int) -> NDArray[np.intp]:
    """Which of a simulation's steps each time since its start falls into; the first or last one beyond the ends.

    Args:
        time: s, of any shape.
        step: s, time step.
        count: number of steps.
    """
    return np.clip((time / step + _ROUNDING).astype(int), 0, count - 1)


def actuator_columns(model: mujoco.MjModel, logs: Sequence[Log]) -> dict[str, int]:
    """Column of `ctrl` for each command of the logs.

    Raises:
        UnknownNameError: a command has no actuator; the message lists the actuators.
    """
    names = {model.actuator(i).name: int(model.actuator_ctrladr[i]) for i in range(model.nactuator)}
    for log in logs:
        for name in log.commands:
            if name not in names:
                raise UnknownNameError("actuator", name, names, "the model (a command is named after its actuator)")
    return {name: names[name] for log in logs for name in log.commands}


def silent_actuators(model: mujoco.MjModel, logs: Sequence[Log]) -> tuple[str, ...]:
    """Actuators that no log has a command for, so that their controls are 0."""
    sent = {name for log in logs for name in log.commands}
    moved = (model.actuator(i).name for i in range(model.nactuator) if model.actuator_ctrlnum[i] > 0)
    return tuple(name for name in moved if name not in sent)


def goes_straight(signal: Signal) -> bool:
    """Whether a command goes straight from sample to sample instead of holding."""
    return signal.between in ("line", "unknown")


def averages(commands: Mapping[str, Signal], columns: Mapping[str, int], nu: int, edges: Array) -> Array:
    """Time average over each step of commands that hold until their next sample, or go straight to it.

    u_k = (1/dt) ∫_{t_k}^{t_k+1} u(t) dt, so an edge inside a step acts with its true impulse. Before its first sample
    a command holds that sample.

    Args:
        commands: the commands; `Signal.between` says what they do from one sample to the next.
        columns: column of each command.
        nu: number of columns; columns without a command are 0.
        edges: times of the steps' edges, shape (w, s + 1).

    Returns:
        Controls, shape (w, s, nu).
    """
    controls = np.zeros((edges.shape[0], edges.shape[1] - 1, nu))
    for name, signal in commands.items():
        integral = _integral(signal, edges)
        controls[:, :, columns[name]] = np.diff(integral, axis=1) / np.diff(edges, axis=1)
    return controls


def _integral(signal: Signal, time: Array) -> Array:
    """∫ of the signal from its first sample to `time`, exact; before its first sample and after its last it holds."""
    waits, rises = np.diff(signal.time), np.diff(signal.value) * goes_straight(signal)
    at_samples = np.concatenate([[0.0], np.cumsum((signal.value[:-1] + 0.5 * rises) * waits)])
    k = np.clip(np.searchsorted(signal.time, time, side="right") - 1, 0, len(signal) - 1)
    since = time - signal.time[k]
    slope = np.append(rises / waits, 0.0)[k]
    return at_samples[k] + (signal.value[k] + 0.5 * slope * np.maximum(since, 0.0)) * since
