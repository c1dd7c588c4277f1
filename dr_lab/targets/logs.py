"""Recorded logs of the real machine: what it was commanded, and how it moved."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from tensordict import TensorDict, pad_sequence

from dr_lab.bounds import FINITE, Positive, above, require_bounds
from dr_lab.collectors.collector import Drive
from dr_lab.diagnosis.windows.commands import averages
from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.recorders.joint_labels import commanded
from dr_lab.targets.target import Target
from dr_lab.targets.task_view import TaskView
from dr_lab.trajectory import Array, Log, MeasurementSet

_ROUNDING = 1e-9  # relative; a command at a bound is within it, and a log of whole steps has the last one


@dataclass(frozen=True)
class _Cut:
    """What `LogsTarget` makes episodes by, in s."""

    half_width: Positive
    stretch: Annotated[float | None, above(0.0), FINITE]

    def __post_init__(self) -> None:
        require_bounds(self, "target")


class LogsTarget(Target):
    """The fitted logs, whole or cut into stretches, on the task's control steps; held-out logs stay unseen.

    Positions and velocities are value and slope of a local cubic through the measured positions; an action is the mean
    of what was commanded during its step, held or straight from sample to sample as the measurements say.

    Args:
        setting: machine and task as this side knows them; every joint is a hinge or a slide.
        measurements: the logs, with ``<joint>.position`` of every joint and a command of every actuator.
        half_width: of the window of the local cubic, s.
        stretch: length of the stretches that a log is cut into, s; what is left at its end is dropped. None: a whole
            log is an episode, or as much of it as the task's episodes are long.

    Raises:
        ConfigError: a number is not above 0; a joint is not measured or an actuator's command is not recorded; a
            command is outside of the task's actions; the task reads more than positions and velocities, or ends where
            an episode begins; no log is as long as a stretch.
    """

    drivable: ClassVar[bool] = False
    nature: ClassVar[str] = "the recorded logs of evaluator.target.measurements"

    def __init__(
        self, setting: Setting, measurements: MeasurementSet, half_width: float, stretch: float | None
    ) -> None:
        compiled = setting.model.nominal()
        self._joints = [f"{compiled.joint(i).name}.position" for i in range(compiled.njnt)]
        self._actuators = [compiled.actuator(row).name for row in commanded(compiled)]
        self._view, self._by = TaskView(setting), _Cut(half_width, stretch)
        for log in measurements.fit:
            missing = [name for name in self._joints if name not in log.outputs]
            missing += [name for name in self._actuators if name not in log.commands]
            if missing or compiled.nq != compiled.njnt:
                known = ", ".join([*log.outputs, *log.commands])
                raise ConfigError(
                    f"Log {log.name} of target=logs has {known}; expected {', '.join(self._joints + self._actuators)}, "
                    "each a number. Choose the measurements of the same machine: "
                    "measurements@….target.measurements=NAME."
                )
        self._episodes = [episode for log in measurements.fit for episode in self._cut(log)]
        if not self._episodes:
            asked = "a control step" if stretch is None else f"{stretch:g} s"
            raise ConfigError(
                f"No log of target=logs that is fitted lasts {asked} from where all joints and commands have begun to "
                "where the first joint ends. Give longer ones, or lower stretch."
            )

    def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
        """So many episodes, evenly spread over all logs; `drive` and `starts` are what they were."""
        if drive is not None or starts is not None:
            raise ConfigError(
                "target=logs cannot be driven: it holds what was commanded once. Play it without a policy, commands or "
                "starts, or take target=plant or target=model."
            )
        known = len(self._episodes)
        if count > known:
            raise ConfigError(
                f"{count} episodes of target=logs are asked for, which has {known}. Ask for fewer, give more logs to "
                "fit, or cut them into shorter ones: target.stretch."
            )
        return pad_sequence([self._episodes[index * known // count] for index in range(count)])

    def _cut(self, log: Log) -> list[TensorDict]:
        """The episodes of a log."""
        measured, sent = [log.outputs[name] for name in self._joints], [log.commands[name] for name in self._actuators]
        first, last = max(s.time[0] for s in (*measured, *sent)), min(signal.time[-1] for signal in measured)
        whole = int((last - first) / self._view.seconds * (1 + _ROUNDING))
        if whole < 1:
            return []
        stretch = self._by.stretch
        wanted = whole if stretch is None else round(stretch / self._view.seconds)
        steps = max(1, min(wanted, self._view.steps))
        instants = first + np.arange(whole + 1) * self._view.seconds
        fits = [local_polynomial(signal, instants, self._by.half_width) for signal in measured]
        qpos, qvel = (np.stack(columns, 1) for columns in ([f.value for f in fits], [f.slope for f in fits]))
        action = self._within(log, self._actions(log, instants))
        begins = range(0, whole - steps + 1, steps)[: 1 if stretch is None else None]
        return [
            self._episode(log, qpos[k : k + steps + 1], qvel[k : k + steps + 1], action[k : k + steps]) for k in begins
        ]

    def _actions(self, log: Log, instants: Array) -> Array:
        """Mean of what was commanded between each two instants, shape (len(instants) − 1, nu)."""
        columns = {name: column for column, name in enumerate(self._actuators)}
        commands = {name: log.commands[name] for name in columns}
        return averages(commands, columns, len(columns), instants[None])[0]

    def _within(self, log: Log, action: Array) -> Array:
        """The actions, unless one is outside of the task's bounds: in the model it would be cut off."""
        low, high = self._view.low, self._view.high
        room = _ROUNDING * (high - low)
        if (action < low - room).any() or (action > high + room).any():
            raise ConfigError(
                f"Log {log.name} of target=logs was commanded from {_listed(action.min(0))} to "
                f"{_listed(action.max(0))}; the task's actions reach from {_listed(low)} to {_listed(high)}. Widen "
                "them: the keys of env.task, such as voltage, or the actuators' ctrlrange."
            )
        return np.clip(action, low, high)

    def _episode(self, log: Log, qpos: Array, qvel: Array, action: Array) -> TensorDict:
        course = self._view.course(qpos, qvel, action)
        if len(course) == 1 < len(action):
            raise ConfigError(
                f"Log {log.name} of target=logs goes where the task ends an episode at once. Choose an environment "
                "whose episodes may go there, such as env=furuta in place of env=furuta_balance."
            )
        return course


def _listed(values: Array) -> str:
    return ", ".join(f"{value:g}" for value in values)
