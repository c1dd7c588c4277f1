"""The true, noise-free motion of a machine between its commands, and what its own equations lack along it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import ConfigError
from dr_lab.plants.alike.path import Path
from dr_lab.plants.body import Body
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine
from dr_lab.plants.memory import SlowInstrument, SlowReading, SlowVelocity
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.plants.rig import Rig
from dr_lab.trajectory import Array

_AT_REST = 1e-7  # rad/s or m/s; a joint that friction holds is slower by orders, one that moves faster


@dataclass(frozen=True)
class Course:
    """One log as K intervals, each with commands that do not change in it.

    Attributes:
        machine: with its true masses and dampings, without anything hidden.
        edge: ends of the intervals, s in the log, shape (K + 1,).
        position: in the middle of each interval, rad or m, shape (K, n).
        velocity: the same, rad/s or m/s.
        acceleration: mean over each interval, shape (K, n).
        kept: memories of the hidden effect in the middle, shape (K, memories).
        path: positions from a little before the first interval to a little after the last, one for each joint.
        shown: the same of what the encoders see without delay and error.
        speed: velocities, one path for each joint, over the same time.
        shown_speed: the same of what tachometers see without delay and noise.
        sent: commands as they were sent, one for each actuator.
        effect: what is hidden.
    """

    machine: MujocoMachine
    edge: Array
    position: Array
    velocity: Array
    acceleration: Array
    kept: Array
    path: Sequence[Path]
    shown: Sequence[Path]
    speed: Sequence[Path]
    shown_speed: Sequence[Path]
    sent: Sequence[Command]
    effect: HiddenEffect

    @property
    def middle(self) -> Array:
        """Middles of the intervals, s, shape (K,)."""
        return 0.5 * (self.edge[1:] + self.edge[:-1])

    @property
    def step(self) -> Array:
        """Lengths of the intervals, s, shape (K,)."""
        return np.diff(self.edge)

    def mean_command(self, effect: HiddenEffect) -> Array:
        """What an effect makes of the commands, averaged over each interval, shape (K, actuators)."""
        acting = [effect.command(name, sent) for name, sent in zip(self.machine.actuators, self.sent, strict=True)]
        return np.stack([mean_held(command, self.edge) for command in acting], axis=1)

    @cached_property
    def measured(self) -> Sequence[Path]:
        """What the encoders show without noise, one for each joint."""
        return self._read(self.effect, self.shown)

    def read_with(self, effect: HiddenEffect) -> Sequence[Path]:
        """What the encoders would show along the course with another effect."""
        return self._read(effect, self._filtered(self.path, effect, SlowReading))

    @cached_property
    def measured_speed(self) -> Sequence[Path]:
        """What tachometers would show without noise, one for each joint."""
        return self._late(self.effect, self.shown_speed)

    def speed_with(self, effect: HiddenEffect) -> Sequence[Path]:
        """What tachometers would show along the course with another effect."""
        return self._late(effect, self._filtered(self.speed, effect, SlowVelocity))

    def _filtered(self, true: Sequence[Path], effect: HiddenEffect, kind: type[SlowInstrument]) -> Sequence[Path]:
        """What instruments of a kind, slowed by an effect, show of the truth, one for each joint."""
        seen = list(true)
        for place, memory in Body.of(self.machine, effect).memories:
            if isinstance(memory, kind):
                seen[place] = seen[place].filtered(memory.constant)
        return seen

    def _late(self, effect: HiddenEffect, seen: Sequence[Path]) -> Sequence[Path]:
        pairs = zip(seen, self.machine.joints, strict=True)
        return [Path(path.time, path.at(path.time - effect.reading_delay(joint))) for path, joint in pairs]

    def _read(self, effect: HiddenEffect, seen: Sequence[Path]) -> Sequence[Path]:
        paths = []
        for path, joint in zip(self._late(effect, seen), self.machine.joints, strict=True):
            paths.append(Path(path.time, effect.reading(joint, path.time, path.value)))
        return paths

    @cached_property
    def true_body(self) -> Body:
        """The true machine with what is hidden in it."""
        return Body.of(self.machine, self.effect)

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Which joints the hidden dry friction holds, shape (K, n)."""
        rubbed = np.zeros(self.position.shape[1], dtype=bool)
        rubbed[[joint for joint, _ in self.true_body.frictions]] = True
        return rubbed & (np.abs(self.velocity) < _AT_REST)

    @cached_property
    def direction(self) -> Array:
        """Mean of sign(q') over each interval, in which the velocity changes evenly, shape (K, n)."""
        change = 0.5 * np.abs(self.acceleration) * self.step[:, None]
        return np.clip(self.velocity / np.maximum(change, _AT_REST), -1.0, 1.0)


def courses(bench: Rig, seed: int, settling: float, parts: int) -> Iterator[Course]:
    """The logs of the machine that a seed stands for, one after the other.

    Args:
        bench: the machine with what is hidden in it.
        seed: of its true parameters and of the commands.
        parts: of the time between two commands, each an interval.
        settling: time at the beginning of a log that is left out, s: what was commanded earlier still acts there.

    Raises:
        ConfigError: the machine's documents are no MJCF file.
    """
    machine = rigid(bench.nominal.machine(bench.nominal.true_values(seed)))
    for number in range(len(bench.peaks)):
        issued, wish = bench.asked(seed, number)
        acts = issued + bench.instruments.actuation_latency
        edge = _parted(acts[(acts > settling) & (acts < bench.duration)], parts)
        instants, first = _around(edge, settling)
        states, command = bench.moved(machine, issued, instants, wish)
        sent = [Command(acts, column, float(column[0])) for column in command.T]
        rows = slice(first, first + 2 * len(edge) - 1)
        yield _course(machine, bench.hidden, edge, (instants, states, rows), sent)


def _course(
    machine: MujocoMachine,
    effect: HiddenEffect,
    edge: Array,
    motion: tuple[Array, Array, slice],
    sent: Sequence[Command],
) -> Course:
    """A log from its instants, its states there and which of them are edges and, between these, middles."""
    joints, body = len(machine.joints), Body.of(machine, effect)
    moving = slice(body.degrees, body.degrees + joints)
    instants, states, rows = motion
    ends, middles = states[rows][0::2], states[rows][1::2]
    velocity = middles[:, moving]
    acceleration = np.diff(ends[:, moving], axis=0) / np.diff(edge)[:, None]
    return Course(
        machine=machine,
        edge=edge,
        position=middles[:, :joints],
        velocity=velocity,
        acceleration=acceleration,
        kept=middles[:, 2 * body.degrees :],
        path=[Path(instants, column) for column in states[:, :joints].T],
        shown=[Path(instants, column) for column in states[:, body.read_columns].T],
        speed=[Path(instants, column) for column in states[:, moving].T],
        shown_speed=[Path(instants, column) for column in states[:, body.velocity_columns].T],
        sent=sent,
        effect=effect,
    )


def _around(edge: Array, margin: float) -> tuple[Array, int]:
    """Edges and middles, with instants as close before and after them as far as a margin, and how many are before."""
    inner = np.sort(np.concatenate([edge, 0.5 * (edge[1:] + edge[:-1])]))
    before = np.arange(edge[0] - (inner[1] - inner[0]), edge[0] - margin, inner[0] - inner[1])[::-1]
    after = np.arange(edge[-1], edge[-1] + margin, inner[-1] - inner[-2])[1:]
    return np.concatenate([before, inner, after]), len(before)


def rigid(machine: Machine) -> MujocoMachine:
    """The machine, if its documents are an MJCF file.

    Raises:
        ConfigError: they are not.
    """
    if not isinstance(machine, MujocoMachine):
        raise ConfigError("Classes are predicted of machines whose documents are an MJCF file; this one has none.")
    return machine


def mean_held(command: Command, edge: Array) -> Array:
    """Mean of a held command over each interval between edges, exactly, shape (K,)."""
    knots = np.unique(np.concatenate([edge, command.edge[(command.edge > edge[0]) & (command.edge < edge[-1])]]))
    area = np.concatenate([[0.0], np.cumsum(command.at(knots[:-1]) * np.diff(knots))])
    return np.diff(np.interp(edge, knots, area)) / np.diff(edge)


def _parted(edge: Array, parts: int) -> Array:
    """Edges of intervals cut into equal parts."""
    inner = np.linspace(edge[:-1], edge[1:], parts, endpoint=False, axis=1).reshape(-1)
    return np.append(inner, edge[-1])
