"""Time series, measured or simulated: one `Signal` a channel, one `Log` an experiment."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import DataError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Signal:
    """One channel over its own clock.

    Attributes:
        name: channel name, ``"<joint>.position"``, ``"<joint>.velocity"``, ``"sensor.<name>"`` or an actuator's name.
        unit: SI unit of `value`.
        time: sample times in s on the log's aligned clock, strictly increasing, shape (n,).
        value: samples, shape (n,) for a scalar, (n, k) for a vector, (n, 4) wxyz for an orientation.
        between: what a command does from one sample to the next: it holds (``hold``), goes straight (``line``), or
            changes without being logged (``unknown``: straight, and what that misses is estimated). ``""`` holds,
            unless the motion says otherwise.

    Raises:
        DataError: shapes disagree, a sample is not finite or time does not increase.
    """

    name: str
    unit: str
    time: Array
    value: Array
    between: str = ""

    def __post_init__(self) -> None:
        if self.time.ndim != 1 or len(self.time) != len(self.value):
            shapes = f"time {self.time.shape}, value {self.value.shape}"
            raise DataError(f"Signal {self.name!r}: {shapes}; expected time (n,) and value (n, …).")
        if not (np.isfinite(self.time).all() and np.isfinite(self.value).all()):
            raise DataError(f"Signal {self.name!r}: samples must be finite; drop NaN and inf first.")
        if (np.diff(self.time) <= 0).any():
            raise DataError(f"Signal {self.name!r}: times must increase; drop duplicates and back-steps first.")

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.time)

    @property
    def wait(self) -> float:
        """Usual time from one sample to the next in s, the median; 0 of a single sample."""
        return float(np.median(np.diff(self.time))) if len(self) > 1 else 0.0


@dataclass(frozen=True)
class Note:
    """One finding of the data contract.

    Attributes:
        kind: short stable word, e.g. ``"gap"``, ``"duplicates"``, ``"glitches"``, ``"nan"``, ``"wrapped"``, ``"cut"``.
        signal: channel it concerns, or ``""`` for the whole log.
        message: one sentence for the user, with numbers.
        count: how many samples it concerns.
    """

    kind: str
    signal: str
    message: str
    count: int = 0


@dataclass(frozen=True)
class ClockFit:
    """How a channel's clock maps onto the log's: t_log = t_channel + offset + drift · (t_channel − t_ref).

    Attributes:
        clock: clock the channel's samples carry (``header``, ``publish``, ``log`` or ``column``).
        offset: s, at the reference time (the channel's first sample).
        drift: s/s.
        jitter: s, median absolute deviation of the stamps' transport delay about the fit.
    """

    clock: str
    offset: float
    drift: float
    jitter: float

    @property
    def fitted(self) -> bool:
        """Whether the numbers were estimated; stamps other than those of headers are taken as they are, with zeros."""
        return self.clock == "header"


@dataclass(frozen=True)
class Log:
    """One measured (or simulated) experiment on one aligned clock.

    Attributes:
        name: short name (the file's stem).
        outputs: measured channels by name; samples keep their own times.
        commands: command channels by actuator name; what they do between samples says `Signal.between`.
        notes: what the data contract found and did.
        clocks: how each channel's clock was aligned, by channel name.
        loaded: whether a load may have been attached; False where the measurements name others that were loaded.
    """

    name: str
    outputs: Mapping[str, Signal]
    commands: Mapping[str, Signal]
    notes: tuple[Note, ...] = ()
    clocks: Mapping[str, ClockFit] = field(default_factory=dict)
    loaded: bool = True


@dataclass(frozen=True)
class Noise:
    """Standard deviation of one channel's measurement noise.

    Attributes:
        std: in the channel's SI unit, > 0.
        unit: that unit.
        source: ``"given"`` or ``"estimated"``.
    """

    std: float
    unit: str
    source: str


@dataclass(frozen=True)
class MeasurementSet:
    """All logs of one machine, their noise, and which are held out.

    Attributes:
        name: name of the measurements configuration.
        fit: logs that parameters may be fitted on.
        held_out: logs never used for fitting.
        noise: noise by channel name, the same for every log.
        gaps: longest time in s between two samples that is not a gap, by channel name; a command without one has none.
    """

    name: str
    fit: tuple[Log, ...]
    held_out: tuple[Log, ...]
    noise: Mapping[str, Noise]
    gaps: Mapping[str, float]
