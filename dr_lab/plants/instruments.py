"""What stands between the machine and its log: encoders, clocks, transport and the driver's own latency."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from dr_lab.bounds import FINITE, RISING, Count, NotNegative, Positive, at_least, numbers
from dr_lab.plants.filtered_difference import FilteredDifference
from dr_lab.plants.noise import Noise
from dr_lab.plants.tachometers import Tachometers
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class RobotClock:
    """The robot's clock beside the host's: robot = host + offset + drift · (host − epoch).

    Attributes:
        offset: s.
        drift: s/s.
        epoch: host time in s at which the offset holds.
    """

    offset: float
    drift: float
    epoch: float

    def read(self, host: Array) -> Array:
        """The robot's time at each host time, s."""
        return host + self.offset + self.drift * (host - self.epoch)


@dataclass(frozen=True)
class Instruments:
    """Sampling, quantisation, clocks and latencies of a bench.

    Attributes:
        sample_rate: encoder samples per second, Hz.
        sample_jitter: standard deviation of a sample's instant, s, cut off at three of them; the stamp tells the truth.
        command_rate: commands per second, Hz.
        command_jitter: largest deviation of a command's instant, s; the stamp tells the truth.
        counts: encoder counts per revolution; None reads the angle exactly.
        clock_offset: smallest and largest offset of the robot's clock, s.
        clock_drift: smallest and largest size of its drift, s/s; the sign is drawn.
        transport_latency: least time in s from a sample to its arrival in the log.
        transport_jitter: mean of the exponential time in s that may be added to it.
        transport_spacing: least time in s between two arrivals; a sample that is held up holds up those behind it.
        actuation_latency: time in s from a command's stamp to its voltage at the motor's driver.
        noise: of the angle before it is counted; None leaves it as it is.
        velocity: how velocities come of the angles, or what measures them; None reports none.
        logged_every: of so many commands one is logged.
    """

    sample_rate: Positive
    sample_jitter: NotNegative
    command_rate: Positive
    command_jitter: NotNegative
    counts: Annotated[int | None, at_least(1)]
    clock_offset: Annotated[Sequence[float], numbers(2, FINITE), RISING]
    clock_drift: Annotated[Sequence[float], numbers(2, FINITE), RISING]
    transport_latency: NotNegative
    transport_jitter: NotNegative
    transport_spacing: NotNegative
    actuation_latency: NotNegative
    noise: Noise | None = None
    velocity: FilteredDifference | Tachometers | None = None
    logged_every: Count = 1

    def sample_times(self, duration: float, generator: np.random.Generator) -> Array:
        """Instants in s after the start at which the encoders are read."""
        grid = np.arange(1, int(duration * self.sample_rate)) / self.sample_rate
        wander = generator.standard_normal(len(grid)).clip(-3.0, 3.0)
        return grid + self.sample_jitter * wander

    def command_times(self, duration: float, generator: np.random.Generator) -> Array:
        """Instants in s after the start at which commands are issued."""
        grid = np.arange(1, int(duration * self.command_rate)) / self.command_rate
        return grid + self.command_jitter * generator.uniform(-1.0, 1.0, len(grid))

    def clock(self, epoch: float, generator: np.random.Generator) -> RobotClock:
        """A robot's clock."""
        sign = 1.0 if generator.random() < 0.5 else -1.0
        offset, drift = (generator.uniform(low, high) for low, high in (self.clock_offset, self.clock_drift))
        return RobotClock(offset, sign * drift, epoch)

    def arrival(self, host: Array, generator: np.random.Generator) -> Array:
        """Host times in s at which samples taken at host times arrive in the log, in order."""
        late = self.transport_latency + self.transport_jitter * generator.standard_exponential(len(host))
        queue = self.transport_spacing * np.arange(len(host))
        return np.asarray(np.maximum.accumulate(host + late - queue) + queue, dtype=np.float64)

    def read(self, position: Array, turns: Array, generator: np.random.Generator) -> Array:
        """Positions in rad or m as the encoders read them, shape (n, joints).

        Args:
            position: rad or m, shape (n, joints).
            turns: angle of each encoder a unit of its joint's position, rad/rad or rad/m, shape (joints,).
            generator: of the noise.
        """
        return self.encode(self.disturbed(position * turns, generator)) / turns

    def reported(
        self, stamp: Array, read: Array, velocity: Array, turns: Array, generator: np.random.Generator
    ) -> Array | None:
        """Velocities in rad/s or m/s as they are logged, shape (n, joints); None where none are.

        Args:
            stamp: of the samples, s, shape (n,).
            read: what the encoders read then, rad or m, shape (n, joints).
            velocity: true ones, rad/s or m/s, shape (n, joints).
            turns: as of `read`.
            generator: of the noise.
        """
        match self.velocity:
            case FilteredDifference() as drive:
                return drive.velocity(stamp, read, self.sample_rate)
            case Tachometers() as axes:
                return axes.measured(velocity * turns, generator) / turns
            case None:
                return None

    def disturbed(self, angle: Array, generator: np.random.Generator) -> Array:
        """Angles in rad with the encoder's noise, shape (n, joints)."""
        if self.noise is None:
            return angle
        count, joints = angle.shape
        return angle + np.stack([self.noise.draw(count, self.sample_rate, generator) for _ in range(joints)], axis=1)

    def white_equal(self) -> float:
        """Standard deviation in rad of the white noise that hides slow motions as much as noise and counts do."""
        noise = 0.0 if self.noise is None else self.noise.white_equal(self.sample_rate)
        count = 0.0 if self.counts is None else 2 * np.pi / self.counts
        return float(np.hypot(noise, count / np.sqrt(12)))

    def encode(self, angle: Array) -> Array:
        """Angles in rad as the encoder reads them: the nearest count."""
        if self.counts is None:
            return angle
        count = 2 * np.pi / self.counts
        return count * np.rint(angle / count)
