"""What a recording shows of one scored log: measured and simulated, side by side."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from dr_lab.errors import DataError
from dr_lab.recorders.force_map import ForceMap
from dr_lab.trajectory import Array, Signal

MEASURED, BEFORE, AFTER = "measured", "before", "after"
SIMULATED = (BEFORE, AFTER)
_SAME = 1e-9  # s, by which a sample at a start may come before it


@dataclass(frozen=True)
class Overlay:
    """One scored log, or a stretch of it, measured and simulated.

    Roles are ``measured``, ``before`` (the model as given or calibrated) and ``after`` (with the effects); a role
    that a run has not is left out.

    Attributes:
        log: name of the log.
        time: times of the poses in s on the log's clock, shape (n,).
        poses: by role, world positions of the bodies in m, shape (n, nbody, 3), and orientations wxyz, (n, nbody, 4).
        measured: channel to signal.
        simulated: by role, channel to values at the measured times, shaped as the measured values; NaN is a gap.
        residual_velocity: by joint, velocity in rad/s or m/s, shape (m,), and by role the residual, shape (m,).
        arguments: by joint, what that residual may be a function of, by its title with unit, shape (m,) each.
        commands: actuator to signal, each value held until the next.
        noise: channel to standard deviation of the measurement noise, in the channel's unit.
        gaps: channel to the longest time in s between two samples that is not a gap; one that is left out has none.
        learned: by joint, what a learned force of the model with the effects is where the residual is told, shape (m,).
        force_maps: by joint, that learned force over position and velocity.
        residual_names: by joint, what `residual_velocity` holds, with its unit, as the axis says it.
        starts: times in s from which on the simulated values begin anew from the measured state, shape (k,).

    Raises:
        DataError: an array has another shape than the above.
    """

    log: str
    time: Array
    poses: Mapping[str, tuple[Array, Array]]
    measured: Mapping[str, Signal]
    simulated: Mapping[str, Mapping[str, Array]]
    residual_velocity: Mapping[str, tuple[Array, Mapping[str, Array]]]
    commands: Mapping[str, Signal]
    noise: Mapping[str, float]
    gaps: Mapping[str, float] = field(default_factory=dict)
    arguments: Mapping[str, Mapping[str, Array]] = field(default_factory=dict)
    learned: Mapping[str, Array] = field(default_factory=dict)
    force_maps: Mapping[str, ForceMap] = field(default_factory=dict)
    residual_names: Mapping[str, str] = field(default_factory=dict)
    starts: Array = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        for role, (position, orientation) in self.poses.items():
            self._expect(f"poses[{role!r}] positions", position, (len(self.time), position.shape[1], 3))
            self._expect(f"poses[{role!r}] orientations", orientation, (len(self.time), position.shape[1], 4))
        for role, channels in self.simulated.items():
            for channel, value in channels.items():
                self._expect(f"simulated[{role!r}][{channel!r}]", value, self.measured[channel].value.shape)
        for joint, (velocity, residuals) in self.residual_velocity.items():
            for role, residual in residuals.items():
                self._expect(f"residual_velocity[{joint!r}][{role!r}]", residual, velocity.shape)
            if joint in self.learned:
                self._expect(f"learned[{joint!r}]", self.learned[joint], velocity.shape)
            for title, value in self.arguments.get(joint, {}).items():
                self._expect(f"arguments[{joint!r}][{title!r}]", value, velocity.shape)

    def _expect(self, name: str, given: Array, shape: tuple[int, ...]) -> None:
        if given.shape != shape:
            raise DataError(f"Overlay of log {self.log!r}: {name} has shape {given.shape}, expected {shape}.")

    def label(self, role: str) -> str:
        """What a role is called on the screen: a model that is shown alone is neither before nor after anything."""
        return "simulated" if role != MEASURED and len(self.simulated) == 1 else role

    def residual_unit(self, channel: str) -> str:
        """Of measured − simulated: the channel's, or rad of the turn between orientations."""
        signal = self.measured[channel]
        return "rad" if is_orientation(signal.value) else signal.unit

    def residual_std(self, channel: str) -> float | None:
        """Noise of measured − simulated: the channel's, or for orientations twice that of a quaternion's components."""
        std = self.noise.get(channel)
        return None if std is None else std * (2.0 if is_orientation(self.measured[channel].value) else 1.0)

    def residual_name(self, joint: str) -> str:
        """What `residual_velocity` holds of a joint."""
        return self.residual_names.get(joint, "residual")

    def joints(self) -> list[str]:
        """Joints that have a residual to draw against the velocity."""
        return [joint for joint, (velocity, residuals) in self.residual_velocity.items() if len(velocity) and residuals]

    def broken(self, time: Array, value: Array) -> tuple[Array, Array]:
        """Samples (n,) and (n, …) with a gap wherever the simulation begins anew: no line joins what is apart."""
        first = np.searchsorted(time, self.starts - _SAME)
        first = np.unique(first[(first > 0) & (first < len(time))])
        between = (time[first - 1] + time[first]) / 2
        return np.insert(time, first, between), np.insert(value, first, np.nan, axis=0)

    def length(self) -> float | None:
        """What the simulation runs for before it begins anew, s; None where that is not known."""
        return float(np.median(np.diff(self.starts))) if len(self.starts) > 1 else None

    def span(self) -> tuple[float, float]:
        """First and last time of the measured signals, s."""
        times = [signal.time for signal in self.measured.values() if len(signal)] or [self.time]
        return float(min(time[0] for time in times)), float(max(time[-1] for time in times))


def is_orientation(value: Array) -> bool:
    """Whether samples are quaternions wxyz, shape (n, 4)."""
    return value.ndim == 2 and value.shape[1] == 4


def components(value: Array) -> Array:
    """A signal's samples as columns, shape (n, k), whatever its rank."""
    return np.reshape(value, (len(value), -1))
