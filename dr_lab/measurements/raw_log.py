"""The channels of one file in SI on the file's log clock, before anything is dropped."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.bounds import Positive, require_bounds
from dr_lab.channel_names import quantity
from dr_lab.errors import ConfigError, DataError
from dr_lab.measurements.alignment import align
from dr_lab.measurements.bag import BagSource
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log_file import BAG, EXPECTED, TABLES, kind
from dr_lab.measurements.mcap import McapSource
from dr_lab.measurements.recordings import Recording
from dr_lab.measurements.row_numbers import RowNumbers
from dr_lab.measurements.samples import Samples, SampleSource
from dr_lab.measurements.signal_map import ChannelMap
from dr_lab.measurements.table import TableSource
from dr_lab.trajectory import Array, ClockFit, Note

_EXAMPLES = {"scale": ", e.g. 1e-9 for ns", "start": " of seconds", "stop": " of seconds"}


@dataclass(frozen=True)
class TimeAxis:
    """Where a log's times come from and which of them count.

    Attributes:
        column: time column of a table.
        unit: of that column.
        scale: factor into that unit, e.g. the period where the column counts samples.
        start: s, earlier samples are left out.
        stop: s, later samples are left out.

    Raises:
        ConfigError: a number is none, the scale is not above 0, or the start not before the stop.
    """

    column: str = "time"
    unit: str = "s"
    scale: Positive = 1.0
    start: float | None = None
    stop: float | None = None

    def __post_init__(self) -> None:
        for key in ("scale", "start", "stop"):
            value = getattr(self, key)
            known = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
            if not known and not (value is None and key != "scale"):
                raise ConfigError(f"time.{key} is {value!r}; expected a number{_EXAMPLES[key]}.")
        require_bounds(self, "time")
        if self.start is not None and self.stop is not None and self.start >= self.stop:
            raise ConfigError(
                f"time.start is {self.start:g} s and time.stop {self.stop:g} s; expected a stop behind the start."
            )


@dataclass(frozen=True)
class RawChannel:
    """One channel of a file on the log's clock, not yet cleaned.

    Attributes:
        channel: its map.
        time: s, shape (n,).
        value: SI, shape (n,) or (n, k).
        missing: messages that did not hold it.
        rows: where the samples of a table stand in its file; None of messages.
    """

    channel: ChannelMap
    time: Array
    value: Array
    missing: int
    rows: RowNumbers | None


@dataclass(frozen=True)
class RawLog:
    """A file's channels; parts of it become logs through `dr_lab.measurements.log.clean`."""

    path: Path
    outputs: tuple[RawChannel, ...]
    commands: tuple[RawChannel, ...]
    clocks: Mapping[str, ClockFit]
    notes: tuple[Note, ...]


def read_raw(
    recording: Recording,
    outputs: Sequence[ChannelMap],
    commands: Sequence[ChannelMap],
    time: TimeAxis,
    contract: DataContract,
) -> RawLog:
    """Read one recording's channels and put them on its log clock; see `dr_lab.measurements.log.read_log`."""
    path = recording.path
    source = open_source(recording, time)
    channels = (*outputs, *commands)
    samples = {channel.name: source.samples(channel) for channel in channels}
    for channel in (*(c for c in outputs if quantity(c.name)), *commands):
        _check_single(channel, samples[channel.name], path.name)
    aligned = align(channels, samples, source.natural_clock, path.name, contract)
    start = -np.inf if time.start is None else time.start
    stop = np.inf if time.stop is None else time.stop

    def raw(channel: ChannelMap, *, held: bool) -> RawChannel:
        found = samples[channel.name]
        at, value = aligned.times[channel.name], channel.to_si(found.value)
        keep = ~((at < (held_since(at, value, start) if held else start)) | (at > stop))
        return RawChannel(channel, at[keep], value[keep], found.missing, found.rows and found.rows.kept(keep))

    return RawLog(
        path,
        tuple(raw(channel, held=False) for channel in outputs),
        tuple(raw(channel, held=True) for channel in commands),
        aligned.clocks,
        (*source.notes, *aligned.notes),
    )


def held_since(time: Array, value: Array, start: float) -> float:
    """When the sample came whose value holds at a start, s; −∞ if there is none. What is not finite holds nothing."""
    return float(time[(time <= start) & np.isfinite(value)].max(initial=-np.inf))


def _check_single(channel: ChannelMap, samples: Samples, file: str) -> None:
    if samples.value.ndim > 1:
        raise DataError(
            f"Channel {channel.name!r} ({channel.source} of {file}) has {samples.value.shape[1]} numbers a sample; a "
            "command, and a joint's position or velocity, is a single one. Take one entry, e.g. [0], or one column."
        )


def open_source(recording: Recording, time: TimeAxis) -> SampleSource:
    """Open a recording by the kind of its file.

    Raises:
        DataError: no such file, or it cannot be read.
        ConfigError: another kind of file.
    """
    path = recording.path
    found = kind(path)
    if found != BAG and not path.is_file():
        raise DataError(f"There is no file {path}.")
    if found == ".mcap":
        return McapSource(path)
    if found in (BAG, ".db3"):
        return BagSource(path)
    if found in TABLES:
        return TableSource(path, time.column, time.unit, time.scale, recording.rows)
    raise ConfigError(f"{path.name}: {EXPECTED}. Convert it to one of these.")
