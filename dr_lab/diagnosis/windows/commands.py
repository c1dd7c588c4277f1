"""Held commands as controls of simulation steps."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from dr_lab.errors import UnknownNameError
from dr_lab.trajectory import Array, Log, Signal


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


def averages(commands: Mapping[str, Signal], columns: Mapping[str, int], nu: int, edges: Array) -> Array:
    """Time average over each step of commands that hold until their next sample.

    u_k = (1/dt) ∫_{t_k}^{t_k+1} u(t) dt, so an edge inside a step acts with its true impulse. Before its first sample
    a command holds that sample.

    Args:
        commands: the held commands.
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
    """∫ of the held signal from its first sample to `time`, exact (the integral is piecewise linear)."""
    at_samples = np.concatenate([[0.0], np.cumsum(signal.value[:-1] * np.diff(signal.time))])
    k = np.clip(np.searchsorted(signal.time, time, side="right") - 1, 0, len(signal) - 1)
    return at_samples[k] + signal.value[k] * (time - signal.time[k])
