"""Experiments on a Furuta pendulum nobody knows exactly: its true parameters, its hidden effect, its logs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.errors import ConfigError
from dr_lab.plants.command import Command
from dr_lab.plants.excitation import SinesAndSteps
from dr_lab.plants.furuta import Furuta, Moments, Motor
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.instruments import Instruments, RobotClock
from dr_lab.plants.motion import Accuracy, simulate
from dr_lab.seeding import stream
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Nominal:
    """What the documents say of the machine.

    Attributes:
        arm_mass: kg.
        arm_length: m.
        arm_damping: N·m·s/rad.
        pole_mass: kg.
        pole_length: m.
        pole_damping: N·m·s/rad.
        motor_constant: N·m/A = V·s/rad.
        motor_resistance: Ω.
        gravity: m/s².
        spread: the true masses and dampings lie within ± this share of these.
    """

    arm_mass: float
    arm_length: float
    arm_damping: float
    pole_mass: float
    pole_length: float
    pole_damping: float
    motor_constant: float
    motor_resistance: float
    gravity: float
    spread: float

    def true_values(self, seed: int) -> dict[str, float]:
        """True masses (kg) and dampings (N·m·s/rad) by the names under which the model declares them."""
        nominal = {
            "arm.mass": self.arm_mass,
            "pole.mass": self.pole_mass,
            "arm.damping": self.arm_damping,
            "pole.damping": self.pole_damping,
        }
        return {
            name: value * (1 + self.spread * stream(seed, "truth", name).uniform(-1.0, 1.0))
            for name, value in nominal.items()
        }

    def machine(self, true: Mapping[str, float]) -> Furuta:
        """The machine with given masses and dampings; lengths, motor and gravity are as documented."""
        return Furuta(
            arm=Moments.rod(true["arm.mass"], self.arm_length),
            pole=Moments.rod(true["pole.mass"], self.pole_length),
            length=self.arm_length,
            damping=(true["arm.damping"], true["pole.damping"]),
            gravity=(0.0, 0.0, -self.gravity),
            motor=Motor(self.motor_constant, self.motor_resistance),
        )


@dataclass(frozen=True)
class Recording:
    """One log of the bench, as its instruments saw it; host times are in s since 1970.

    Attributes:
        name: the log's name.
        stamp: the robot's clock at each encoder sample, s, shape (n,).
        arrival: host time at which each sample reached the log, s, shape (n,).
        position: encoder readings (arm, pole), rad, shape (n, 2).
        command_time: host time at which each command was issued, s, shape (m,).
        voltage: commands, V, shape (m,).
    """

    name: str
    stamp: Array
    arrival: Array
    position: Array
    command_time: Array
    voltage: Array


@dataclass(frozen=True)
class Bench:
    """A machine, what is hidden in it, how it is excited and what is seen of it.

    Attributes:
        nominal: documented constants.
        hidden: the hidden effect.
        excitation: shape of the voltage, with its limit in V.
        peaks: largest |voltage| of each log in V; their number is the number of logs, log_1, log_2 ….
        duration: length of a log in s.
        pause: time from the start of one log to the start of the next, s.
        epoch: host time of the first log, s since 1970.
        instruments: encoders, clocks and latencies.
        accuracy: how closely the motion is followed.

    Raises:
        ConfigError: no log is asked for, or one too short for a command and a sample.
    """

    nominal: Nominal
    hidden: HiddenEffect
    excitation: SinesAndSteps
    peaks: Sequence[float]
    duration: float
    pause: float
    epoch: float
    instruments: Instruments
    accuracy: Accuracy

    def __post_init__(self) -> None:
        slowest = min(self.instruments.sample_rate, self.instruments.command_rate)
        if not self.peaks or self.duration * slowest < 2:
            given = f"{len(self.peaks)} peaks, {self.duration} s"
            raise ConfigError(f"A bench needs a peak voltage for each log and two samples in it; got {given}.")

    def recordings(self, seed: int) -> Iterator[Recording]:
        """The logs of the machine that a seed stands for, one after the other; each starts hanging at rest."""
        machine = self.nominal.machine(self.nominal.true_values(seed))
        clock = self.clock(seed)
        for index, peak in enumerate(self.peaks):
            yield self._record(machine, clock, seed, index, peak)

    def clock(self, seed: int) -> RobotClock:
        """The robot's clock of the machine that a seed stands for."""
        return self.instruments.clock(self.epoch, stream(seed, "clock"))

    def _record(self, machine: Furuta, clock: RobotClock, seed: int, index: int, peak: float) -> Recording:
        name = f"log_{index + 1}"
        start = self.epoch + index * self.pause
        issued = start + self.instruments.command_times(self.duration, stream(seed, name, "command"))
        sampled = start + self.instruments.sample_times(self.duration, stream(seed, name, "sample"))
        voltage = self.excitation.command(issued - start, peak, stream(seed, name, "excitation"))
        # Times since 1970 are rounded to the clock's resolution; what happens, happens at the rounded times.
        applied = Command(issued - start + self.instruments.actuation_latency, voltage)
        return Recording(
            name=name,
            stamp=clock.read(sampled),
            arrival=self.instruments.arrival(sampled, stream(seed, name, "transport")),
            position=self.instruments.encode(self.angles(machine, applied, sampled - start)),
            command_time=issued,
            voltage=voltage,
        )

    def angles(self, machine: Furuta, applied: Command, time: Array) -> Array:
        """Angles (arm, pole) in rad that the encoders are about to round, shape (n, 2); time in s after the start."""
        read = time[:, None] - np.asarray(self.hidden.reading_delay())
        instants, where = np.unique(read, return_inverse=True)
        states = simulate(machine, self.hidden, applied, instants, accuracy=self.accuracy)
        rows = where.reshape(read.shape)
        return np.stack([states[rows[:, joint], joint] for joint in (0, 1)], axis=1)
