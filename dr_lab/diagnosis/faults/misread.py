"""Channels and commands read in another unit or order than declared, by which the equation of motion holds."""

import functools
import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.faults.drive_fit import Forces
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.fault_words import known_factors, position_units, remedy_of_factor, remedy_of_unit
from dr_lab.diagnosis.faults.smoothed_motion import Index, Motion, smoothed_motion
from dr_lab.diagnosis.windows.commands import silent_actuators
from dr_lab.trajectory import Array, Log, MeasurementSet


@dataclass(frozen=True)
class Misreading:
    """Another reading of the logs, by which the model explains them far better.

    Attributes:
        kind: ``"unit"`` or ``"swapped"``.
        signal: the channel or command.
        message: what was seen, with figures.
        remedy: what to write.
    """

    kind: str
    signal: str
    message: str
    remedy: str


@dataclass(frozen=True)
class _Reading:
    kind: str
    signal: str
    told: str
    remedy: str
    motion: Callable[[Motion], Motion]
    logs: Callable[[Sequence[Log]], Sequence[Log]]


def misread(forces: Forces, measured: MeasurementSet) -> Misreading | None:
    """The other reading of one channel, or of two that are exchanged, that leaves far less of all joints' forces.

    Every reading is judged on the same logs: the mean over the joints of the share of their forces that stays
    unexplained, where a joint's share counts 1 at most. It must also leave far less than any gain of the commands as
    declared would, of which `suspect_faults` tells log by log. Other readings that leave about as little as the best
    one are named beside it. Only joints of which much is unexplained are read anew.

    Args:
        forces: those of all logs as declared.
        measured: all logs.

    Returns:
        The misreading; None where the logs are explained as declared, or no reading explains them far better.
    """
    model, settings = forces.model, forces.settings
    plausible = (settings.gain, 1 / settings.gain)
    bad = np.flatnonzero(forces.unexplained(*plausible) >= settings.share).tolist()
    if not bad or silent_actuators(model, forces.logs):
        return None
    motion = smoothed_motion(model, measured, logs := first_logs(forces.logs, settings), settings.equation)
    declared = Forces.of(model, logs, motion, settings)
    if (given := _mean(declared.unexplained(*plausible))) < settings.share:
        return None
    least = _mean(declared.unexplained(-np.inf, np.inf))
    every = [*_positions(model, motion, logs, bad), *_swaps(model, logs, bad)]
    every += [*_commands(model, forces, bad), *_command_swaps(model, forces, bad)]
    anew = (Forces.of(model, each.logs(logs), each.motion(motion), settings) for each in every)
    tried = [(_mean(read.unexplained(*plausible)), each) for read, each in zip(anew, every, strict=True)]
    far = sorted((pair for pair in tried if pair[0] <= settings.contrast * least), key=lambda pair: pair[0])
    if not far:
        return None
    (left, best), *others = far
    equal = [each for other, each in others if settings.contrast * other <= left]
    message = (
        f"{best.told}: so read, the logs leave {100 * left:.2g} % of the joints' forces unexplained; as declared, "
        f"{100 * given:.2g} %."
    )
    beside = "".join(f" Or {each.told}, which the logs do not tell apart: {each.remedy}" for each in equal)
    return Misreading(best.kind, best.signal, message, f"{best.remedy}{beside}")


def first_logs(logs: Sequence[Log], settings: FaultSettings) -> list[Log]:
    """The first logs that last so long together at most, one at least."""
    lengths = np.cumsum([max(float(np.ptp(signal.time)) for signal in log.outputs.values()) for log in logs])
    return list(logs[: max(int(np.count_nonzero(lengths <= settings.misread_seconds)), 1)])


def _mean(shares: Array) -> float:
    """Over the joints; a share above 1 says no more than 1 does."""
    return float(np.minimum(shares, 1.0).mean())


def _positions(model: mujoco.MjModel, motion: Motion, logs: Sequence[Log], dofs: Sequence[int]) -> Iterator[_Reading]:
    """Positions in another unit, with the velocities that they have."""
    for dof in dofs:
        name = _channel(model, dof, logs)
        if not motion.qvel[:, dof].any():
            continue
        for true, called, factor in position_units(logs[0].outputs[name].unit):
            told = f"{name} seems to be in {true} and called {called}"
            remedy = remedy_of_unit(f"measurements.outputs.{name}", true, called, factor)
            yield _Reading("unit", name, told, remedy, _scaled(dof, factor), lambda logs: logs)


def _swaps(model: mujoco.MjModel, logs: Sequence[Log], dofs: Sequence[int]) -> Iterator[_Reading]:
    for one, other in itertools.combinations(dofs, 2):
        first, second = (_channel(model, dof, logs) for dof in (one, other))
        told = f"{first} and {second} seem to be exchanged"
        remedy = f"Exchange what measurements.outputs names for {first} and {second}, with their units."
        order = np.arange(model.nv)
        order[[one, other]] = other, one
        yield _Reading("swapped", first, told, remedy, _ordered(order), lambda logs: logs)


def _commands(model: mujoco.MjModel, forces: Forces, dofs: Sequence[int]) -> Iterator[_Reading]:
    """Commands in another unit, of the actuators that move these joints."""
    for name in _driving(model, forces, dofs):
        unit = next(log.commands[name].unit for log in forces.logs if name in log.commands)
        for words, factor in known_factors(unit).items():
            told = f"{name} seems to be in {words}"
            remedy = remedy_of_factor(name, factor)
            yield _Reading("unit", name, told, remedy, lambda motion: motion, _multiplied(name, factor))


def _command_swaps(model: mujoco.MjModel, forces: Forces, dofs: Sequence[int]) -> Iterator[_Reading]:
    """Commands of two of the actuators that move these joints, exchanged."""
    for one, other in itertools.combinations(_driving(model, forces, dofs), 2):
        told, remedy = exchanged_words(one, other)
        read = functools.partial(_all_exchanged, one=one, other=other)
        yield _Reading("swapped", one, told, remedy, lambda motion: motion, read)


def exchanged_words(one: str, other: str) -> tuple[str, str]:
    """That the commands of two actuators seem to be exchanged, and what to do."""
    told = f"the commands of {one} and {other} seem to be exchanged"
    return told, f"Exchange what measurements.commands names for {one} and {other}."


def exchanged(log: Log, one: str, other: str) -> Log:
    """A log with the commands of two actuators exchanged; the same where it lacks one."""
    if not {one, other} <= log.commands.keys():
        return log
    return replace(log, commands={**log.commands, one: log.commands[other], other: log.commands[one]})


def _all_exchanged(logs: Sequence[Log], one: str, other: str) -> Sequence[Log]:
    return [exchanged(log, one, other) for log in logs]


def _driving(model: mujoco.MjModel, forces: Forces, dofs: Sequence[int]) -> list[str]:
    """Names of the commanded actuators that move these joints."""
    joints = {model.joint(int(model.dof_jntid[dof])).name for dof in dofs}
    return list(dict.fromkeys(fit.actuator for fit in forces.drives() if fit.joint in joints))


def _channel(model: mujoco.MjModel, dof: int, logs: Sequence[Log]) -> str:
    joint = model.joint(int(model.dof_jntid[dof])).name
    return next(name for name in (f"{joint}.position", f"{joint}.velocity") if name in logs[0].outputs)


def _scaled(dof: int, factor: float) -> Callable[[Motion], Motion]:
    def read(motion: Motion) -> Motion:
        factors: Array = np.ones(motion.qvel.shape[1])
        factors[dof] = factor
        return replace(motion, qpos=factors * motion.qpos, qvel=factors * motion.qvel, qacc=factors * motion.qacc)

    return read


def _ordered(order: Index) -> Callable[[Motion], Motion]:
    def read(motion: Motion) -> Motion:
        return replace(motion, qpos=motion.qpos[:, order], qvel=motion.qvel[:, order], qacc=motion.qacc[:, order])

    return read


def _multiplied(name: str, factor: float) -> Callable[[Sequence[Log]], Sequence[Log]]:
    def read(logs: Sequence[Log]) -> Sequence[Log]:
        return [
            replace(log, commands={**log.commands, name: replace(sent, value=factor * sent.value)})
            if (sent := log.commands.get(name)) is not None
            else log
            for log in logs
        ]

    return read
