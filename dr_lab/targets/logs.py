"""Recorded logs of the real machine: what it was commanded, and how it moved."""

import numpy as np
from tensordict import TensorDict, pad_sequence

from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.targets.target import Drive, Target
from dr_lab.targets.task_view import TaskView
from dr_lab.trajectory import Array, Log, MeasurementSet, Signal


class LogsTarget(Target):
    """The logs, held-out ones last, on the task's control steps.

    Positions and velocities are value and slope of a local cubic through the measured positions; an action is the mean
    of what was commanded during its step.

    Args:
        setting: machine and task as this side knows them; every joint is a hinge or a slide.
        measurements: the logs, with ``<joint>.position`` of every joint and a command of every actuator.
        half_width: of the window of the local cubic, s.

    Raises:
        ConfigError: a joint is not measured or an actuator's command is not recorded, or the task reads more than
            positions and velocities.
    """

    def __init__(self, setting: Setting, measurements: MeasurementSet, half_width: float) -> None:
        compiled = setting.model.nominal()
        self._joints = [f"{compiled.joint(i).name}.position" for i in range(compiled.njnt)]
        self._actuators = [compiled.actuator(i).name for i in range(compiled.nu)]
        self._view, self._half_width = TaskView(setting), half_width
        self._logs = (*measurements.fit, *measurements.held_out)
        for log in self._logs:
            missing = [name for name in self._joints if name not in log.outputs]
            missing += [name for name in self._actuators if name not in log.commands]
            if missing or compiled.nq != compiled.njnt:
                known = ", ".join([*log.outputs, *log.commands])
                raise ConfigError(
                    f"Log {log.name} of target=logs has {known}; expected {', '.join(self._joints + self._actuators)}, "
                    "each a number. Choose the measurements of the same machine: "
                    "measurements@….target.measurements=NAME."
                )

    def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
        """The first `count` logs, up to where the task ends an episode; `drive` and `starts` are what they were."""
        if drive is not None or starts is not None:
            raise ConfigError(
                "target=logs cannot be driven: it holds what was commanded once. Play it without a policy, commands or "
                "starts, or take target=plant or target=model."
            )
        if count > len(self._logs):
            raise ConfigError(f"{count} episodes of target=logs are asked for, which has {len(self._logs)} logs.")
        return pad_sequence([self._course(log) for log in self._logs[:count]])

    def _course(self, log: Log) -> TensorDict:
        measured, sent = [log.outputs[name] for name in self._joints], [log.commands[name] for name in self._actuators]
        first, last = max(s.time[0] for s in (*measured, *sent)), min(signal.time[-1] for signal in measured)
        steps = min(int((last - first) / self._view.seconds), self._view.steps)
        instants = first + np.arange(steps + 1) * self._view.seconds
        fits = [local_polynomial(signal, instants, self._half_width) for signal in measured]
        qpos, qvel = (np.stack(columns, 1) for columns in ([f.value for f in fits], [f.slope for f in fits]))
        action = np.stack([_means(signal, instants) for signal in sent], 1)
        return self._view.course(qpos, qvel, np.clip(action, self._view.low, self._view.high))


def _means(command: Signal, instants: Array) -> Array:
    """Mean between each two instants of what holds from one sample to the next, shape (len(instants) − 1,)."""
    edges = np.append(command.time, max(instants[-1], command.time[-1]))
    integral = np.concatenate([[0.0], np.cumsum(command.value * np.diff(edges))])
    return np.diff(np.interp(instants, edges, integral)) / np.diff(instants)
