"""Experiments on a machine nobody knows exactly: its true parameters, its hidden effect, its logs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from dr_lab.bounds import FINITE, NotNegative, Positive, numbers
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.plants.body import Body
from dr_lab.plants.excitation import SinesAndSteps
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.instruments import Instruments, RobotClock
from dr_lab.plants.machine import Machine
from dr_lab.plants.memory import SlowVelocity
from dr_lab.plants.motion import Accuracy
from dr_lab.plants.nominal import Nominal
from dr_lab.plants.operator import Experiment, Operator
from dr_lab.plants.phases import State
from dr_lab.plants.tachometers import Tachometers
from dr_lab.seeding import stream
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class RigRecording:
    """One log of the bench, as its instruments saw it; host times are in s since 1970.

    Attributes:
        name: the log's name.
        stamp: the robot's clock at each encoder sample, s, shape (n,).
        arrival: host time at which each sample reached the log, s, shape (n,).
        position: encoder readings of the joints, rad or m, shape (n, joints).
        command_time: host time at which each command was issued, s, shape (k,).
        command: commands to the actuators, shape (k, actuators).
        velocity: what is reported of the joints' velocities, rad/s or m/s, shape (n, joints); None where nothing is.
    """

    name: str
    stamp: Array
    arrival: Array
    position: Array
    command_time: Array
    command: Array
    velocity: Array | None = None


@dataclass(frozen=True)
class Rig:
    """A machine, what is hidden in it, how it is excited and what is seen of it.

    Attributes:
        nominal: documented constants.
        hidden: the hidden effect.
        excitation: shape of what is wished of each actuator, with its limit.
        operator: what makes commands of the wish.
        peaks: largest size of the wish in each log; their number is the number of logs.
        shares: size of an actuator's wish relative to the peaks, 1 where it is not named.
        start: where joints are at the beginning of a log, at rest, rad or m; 0 where a joint is not named.
        duration: length of a log in s.
        pause: time from the start of one log to the start of the next, s.
        epoch: host time of the first log, s since 1970.
        instruments: encoders, clocks and latencies.
        travel: way that a slide moves in one revolution of its encoder, m; a joint that is not named is a hinge.
        accuracy: how closely the motion is followed.
        commanded: what the actuators are asked for, as the commands' topic calls it.
        series: what logs are called before their number: log_1, log_2 ….

    Raises:
        ConfigError: no log is asked for, or one too short for a command and a sample; a slide does not move in a
            revolution of its encoder; velocities are filtered that nothing measures.
        UnknownNameError: the machine has no such joint or actuator.
    """

    nominal: Nominal
    hidden: HiddenEffect
    excitation: SinesAndSteps
    operator: Operator
    peaks: Annotated[Sequence[float], numbers(None, FINITE)]
    shares: Mapping[str, float]
    start: Mapping[str, float]
    duration: Positive
    pause: NotNegative
    epoch: NotNegative
    instruments: Instruments
    travel: Mapping[str, float]
    accuracy: Accuracy
    commanded: str
    series: str = "log"

    def __post_init__(self) -> None:
        slowest = min(self.instruments.sample_rate, self.instruments.command_rate)
        if not self.peaks or self.duration * slowest < 2:
            given = f"{len(self.peaks)} peaks, {self.duration} s"
            raise ConfigError(f"A bench needs a peak command for each log and two samples in it; got {given}.")
        filtered = any(isinstance(memory, SlowVelocity) for memory in self.hidden.memories())
        if filtered and not isinstance(self.instruments.velocity, Tachometers):
            raise ConfigError(
                f"Hidden effect {self.hidden.label} filters measured velocities; these instruments measure none. "
                "Give plant/instruments=tachometers."
            )
        for joint, way in self.travel.items():
            if not way > 0:
                raise ConfigError(f"plant.travel: {joint} is {way:g} m; expected a number above 0.")
        for kind, given, known in (
            ("joint", self.start, self.joints),
            ("joint", self.travel, self.joints),
            ("actuator", self.shares, self.actuators),
        ):
            for name in given:
                if name not in known:
                    raise UnknownNameError(kind, name, known, "the plant")

    @property
    def documented(self) -> Machine:
        """The machine as documented."""
        return self.nominal.machine(self.nominal.documented())

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the measured joints."""
        return self.documented.joints

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuators."""
        return self.documented.actuators

    def recordings(self, seed: int) -> Iterator[RigRecording]:
        """The logs of the machine that a seed stands for, one after the other; each starts at rest."""
        machine = self.nominal.machine(self.nominal.true_values(seed))
        clock = self.clock(seed)
        for number in range(len(self.peaks)):
            yield self._record(machine, clock, seed, number)

    def clock(self, seed: int) -> RobotClock:
        """The robot's clock of the machine that a seed stands for."""
        return self.instruments.clock(self.epoch, stream(seed, "clock"))

    def _record(self, machine: Machine, clock: RobotClock, seed: int, number: int) -> RigRecording:
        name, start = f"{self.series}_{number + 1}", self._start_of(number)
        sampled = start + self.instruments.sample_times(self.duration, stream(seed, name, "sample"))
        after, wish = self.asked(seed, number)
        position, velocity, command = self.played(machine, after, sampled - start, wish)
        issued = start + after
        tools, stamp = self.instruments, clock.read(sampled)
        position = tools.read(position, self.turns, stream(seed, name, "noise"))
        return RigRecording(
            name=name,
            stamp=stamp,
            arrival=tools.arrival(sampled, stream(seed, name, "transport")),
            position=position,
            command_time=issued[:: tools.logged_every],
            command=command[:: tools.logged_every],
            velocity=tools.reported(stamp, position, velocity, self.turns, stream(seed, name, "velocity")),
        )

    def asked(self, seed: int, number: int) -> tuple[Array, Array]:
        """What is asked in a log, 0 the first: instants in s after its start, shape (k,), and wishes, shape (k, m)."""
        name, start = f"{self.series}_{number + 1}", self._start_of(number)
        # Times since 1970 are rounded to the clock's resolution; what happens, happens at the rounded times.
        issued = start + self.instruments.command_times(self.duration, stream(seed, name, "command")) - start
        return issued, self._wish(issued, self.peaks[number], stream(seed, name, "excitation"))

    def _start_of(self, number: int) -> float:
        return self.epoch + number * self.pause

    def _wish(self, time: Array, peak: float, generator: np.random.Generator) -> Array:
        sizes = [peak * self.shares.get(name, 1.0) for name in self.actuators]
        return np.stack([self.excitation.command(time, size, generator) for size in sizes], axis=1)

    def played(self, machine: Machine, issued: Array, sampled: Array, wish: Array) -> tuple[Array, Array, Array]:
        """What the encoders are about to round and the tachometers to blur, and the commands.

        Args:
            machine: the machine without its hidden effect.
            issued: instants of the commands in s after the start, shape (k,).
            sampled: instants of the samples in s after the start, shape (n,).
            wish: what is wished of the actuators, shape (k, actuators).

        Returns:
            Positions of the joints in rad or m and their velocities in rad/s or m/s, both of shape (n, joints), and
            commands, shape (k, actuators).
        """
        joints = machine.joints
        read = sampled[:, None] - np.array([self.hidden.reading_delay(joint) for joint in joints])
        instants, where = np.unique(read, return_inverse=True)
        states, command = self.moved(machine, issued, instants, wish)
        body, where = Body.of(machine, self.hidden), where.reshape(read.shape)
        position = np.take_along_axis(states[:, body.read_columns], where, axis=0)
        velocity = np.take_along_axis(states[:, body.velocity_columns], where, axis=0)
        columns = [self.hidden.reading(joint, sampled, position[:, row]) for row, joint in enumerate(joints)]
        return np.stack(columns, axis=1), velocity, command

    def moved(self, machine: Machine, issued: Array, instants: Array, wish: Array) -> tuple[Array, Array]:
        """How the machine moves with what is hidden in it: states as by `motion.simulate`, and the commands.

        Args:
            machine: as for `played`, likewise `issued` and `wish`.
            issued: instants of the commands, s.
            instants: when the motion is reported, s after the start, not decreasing, shape (n,).
            wish: what is wished.
        """
        experiment = Experiment(
            machine=machine,
            effect=self.hidden,
            documented=self.documented,
            issued=issued,
            latency=self.instruments.actuation_latency,
            instants=instants,
            start=self._start(),
            accuracy=self.accuracy,
        )
        return self.operator.operate(experiment, wish)

    def _start(self) -> State:
        return (*(self.start.get(joint, 0.0) for joint in self.joints), *(0.0 for _ in self.joints))

    @property
    def turns(self) -> Array:
        """Angle of each joint's encoder a unit of its position, rad/rad or rad/m, shape (joints,)."""
        return np.array([2 * np.pi / self.travel[joint] if joint in self.travel else 1.0 for joint in self.joints])
