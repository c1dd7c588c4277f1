"""Measured logs as MCAP: what a CSV file holds, for tools that read ROS 2 messages."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain, count

import numpy as np

from dr_lab.channel_names import POSITION, VELOCITY, is_sensor, joint_of, quantity, sensor_of
from dr_lab.errors import DataError
from dr_lab.recorders.mcap import FloatArrays, JointStates
from dr_lab.sources.source import NamedLog
from dr_lab.trajectory import Array, Log, MeasurementSet, Signal


@dataclass(frozen=True)
class CsvSource:
    """Logs as they were read: in SI units, cleaned, on each log's aligned clock.

    A joint state needs a position of every joint. Where joints were sampled at different times, or some have no
    velocity, the missing numbers are NaN, which readers leave out. A log that begins before time 0, where MCAP has no
    times, is shifted as a whole to begin at 0; the file's metadata say by how much.

    Attributes:
        measurements: the logs.
        joint_topic: topic of all joints' positions and velocities, ``sensor_msgs/msg/JointState``.
        command_topic: each command goes to ``<command_topic>/<actuator>``, ``std_msgs/msg/Float64MultiArray``.
        sensor_topic: each sensor goes to ``<sensor_topic>/<sensor>``, the same type.
    """

    measurements: MeasurementSet
    joint_topic: str
    command_topic: str
    sensor_topic: str

    def logs(self, seed: int) -> Iterator[NamedLog]:
        """The logs to fit on, then those held out; nothing is random."""
        del seed
        logs = (*self.measurements.fit, *self.measurements.held_out)
        return map(self._named, logs, _stems(log.name for log in logs))

    def companions(self, seed: int) -> Mapping[str, bytes]:
        """None."""
        del seed
        return {}

    def _named(self, log: Log, stem: str) -> NamedLog:
        shift = max(0.0, -min(signal.time[0] for signal in (*log.outputs.values(), *log.commands.values())))
        log = replace(log, outputs=_later(log.outputs, shift), commands=_later(log.commands, shift))
        joints = _joint_states(self.joint_topic, log)
        sensors = [
            _floats(f"{self.sensor_topic}/{sensor_of(name)}", signal)
            for name, signal in log.outputs.items()
            if is_sensor(name)
        ]
        commands = [_floats(f"{self.command_topic}/{name}", signal) for name, signal in log.commands.items()]
        notes = {f"note.{number}": note.message for number, note in enumerate(log.notes)}
        shifted = {"shift": f"{shift:.9f} s"} if shift else {}
        origin = {"source": self.measurements.name, "log": log.name}
        return NamedLog(stem, (*joints, *sensors, *commands), {**origin, **shifted, **notes})


def _stems(names: Iterable[str]) -> tuple[str, ...]:
    """File names for logs: a stretch is called log[a:b], which no file should be; equal ones are counted."""
    stems: list[str] = []
    for name in names:
        plain = re.sub(r"[^\w.\-]+", "_", name).strip("_")
        counted = chain([plain], (f"{plain}_{number}" for number in count(2)))
        stems.append(next(stem for stem in counted if stem not in stems))
    return tuple(stems)


def _later(signals: Mapping[str, Signal], shift: float) -> dict[str, Signal]:
    return {name: replace(signal, time=signal.time + shift) for name, signal in signals.items()}


def _joint_states(topic: str, log: Log) -> list[JointStates]:
    """One topic with every joint that has a position; none without joints."""
    joints = tuple(joint_of(name) for name in log.outputs if quantity(name) == POSITION)
    alone = [name for name in log.outputs if quantity(name) == VELOCITY and joint_of(name) not in joints]
    if alone:
        raise DataError(
            f"Log {log.name!r}: {alone[0]!r} is measured without its joint's position, which a joint state needs."
        )
    if not joints:
        return []
    signals = [log.outputs[name] for name in log.outputs if not is_sensor(name)]
    time = np.unique(np.concatenate([signal.time for signal in signals]))
    position = np.stack([_on(time, log.outputs[f"{joint}.{POSITION}"]) for joint in joints], axis=1)
    velocity = np.stack([_on(time, log.outputs.get(f"{joint}.{VELOCITY}")) for joint in joints], axis=1)
    known = velocity if np.isfinite(velocity).any() else None
    return [JointStates(topic, joints, time, time, position, known)]


def _on(time: Array, signal: Signal | None) -> Array:
    """A signal's samples at their places among `time`, NaN elsewhere."""
    value = np.full(len(time), np.nan)
    if signal is not None:
        value[np.searchsorted(time, signal.time)] = signal.value
    return value


def _floats(topic: str, signal: Signal) -> FloatArrays:
    data = signal.value.reshape(len(signal), -1)
    labels = (signal.name,) if data.shape[1] == 1 else tuple(f"{signal.name}[{k}]" for k in range(data.shape[1]))
    return FloatArrays(topic, labels, signal.time, data)
