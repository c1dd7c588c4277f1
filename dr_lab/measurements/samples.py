"""One channel as its file holds it, before clocks are aligned and samples cleaned."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.row_numbers import RowNumbers
from dr_lab.measurements.signal_map import ChannelMap, Reading, names_of
from dr_lab.trajectory import Array, Note


@dataclass(frozen=True)
class Stamps:
    """The stamps of one clock.

    Attributes:
        elapsed: s since a zero that all channels of the file share for this clock, shape (n,); NaN where nobody set it.
        zero: that zero in s after the file's own (its first log time, or its first row); a robot's clock may be off
            by decades, and a difference that large would cost `elapsed` its digits.
    """

    elapsed: Array
    zero: float


@dataclass(frozen=True)
class Samples:
    """Raw numbers of one channel.

    Attributes:
        value: shape (n,) or (n, k), in the file's unit; NaN where the file has no number.
        stamps: by clock (``header``, ``publish``, ``log`` or ``column``).
        stream: topic or file whose messages or rows the samples come from; they share their stamps.
        missing: messages of the stream that do not hold the channel at all.
        rows: where the samples of a table stand in its file; None of messages.
    """

    value: Array
    stamps: Mapping[str, Stamps]
    stream: str
    missing: int
    rows: RowNumbers | None = None


class SampleSource(Protocol):
    """An opened log file."""

    @property
    def notes(self) -> tuple[Note, ...]:
        """What was found on opening, e.g. a cut file."""
        ...

    @property
    def natural_clock(self) -> str:
        """The clock to use where the configuration names none."""
        ...

    def samples(self, channel: ChannelMap) -> Samples:
        """Read one channel."""
        ...


def combine(channel: ChannelMap, part: Callable[[str], Array]) -> Array:
    """Weighted sums of the parts that a channel's readings name, shape (n,), (n, k) for a vector channel.

    Raises:
        DataError: the channel adds lists of different lengths, or makes a vector of lists.
    """
    parts = {name: _plain(part(name)) for name in names_of(channel.readings)}
    widths = {name: values.shape[1:] for name, values in parts.items()}
    if len({*widths.values()}) > 1 or (channel.vector and any(widths.values())):
        found = ", ".join(f"{name} {width[0] if width else 1}" for name, width in widths.items())
        raise DataError(
            f"Channel {channel.name!r} ({channel.source}) puts together lists of numbers; expected single ones. Their "
            f"lengths: {found}. Take one entry of each list, e.g. [0]."
        )

    def total(reading: Reading) -> Array:
        return np.sum([weight * parts[name] for name, weight in reading.items()], axis=0)

    sums = [total(reading) for reading in channel.readings]
    return np.stack(sums, axis=-1) if channel.vector else sums[0]


def _plain(values: Array) -> Array:
    """A list of a single number is that number."""
    return values[:, 0] if values.ndim == 2 and values.shape[1] == 1 else values
