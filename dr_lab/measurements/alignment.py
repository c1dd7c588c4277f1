"""All channels of a file on its log clock."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.clocks import ClockLine, describe, fit_line, pool, steps
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.samples import Samples, Stamps
from dr_lab.measurements.signal_map import ChannelMap
from dr_lab.trajectory import Array, ClockFit, Note


@dataclass(frozen=True)
class Aligned:
    """Times of all channels.

    Attributes:
        times: by channel, s on the log's clock, latency subtracted, in the order of the samples.
        clocks: how each channel's clock was mapped, by channel.
        notes: clocks that do not run straight.
    """

    times: Mapping[str, Array]
    clocks: Mapping[str, ClockFit]
    notes: tuple[Note, ...]


def align(
    channels: Sequence[ChannelMap],
    samples: Mapping[str, Samples],
    natural_clock: str,
    file: str,
    contract: DataContract,
) -> Aligned:
    """Put every channel on the file's log clock.

    Stamps of the log, of the publisher and of a table's column are taken as they are. Header stamps are another
    computer's clock: offset and drift against the log time are estimated for each topic (see
    `dr_lab.measurements.clocks.fit_line`), once for topics that share a clock.

    Args:
        channels: all channels.
        samples: theirs, by name.
        natural_clock: for channels that name none.
        file: for messages.
        contract: thresholds.

    Raises:
        DataError: a channel has no stamps of its clock, or they do not move.
    """
    chosen = {channel.name: channel.clock or natural_clock for channel in channels}
    stamps = {channel.name: _stamps(channel, samples[channel.name], chosen[channel.name], file) for channel in channels}
    pairs = {
        samples[name].stream: (stamps[name].elapsed, samples[name].stamps["log"].elapsed)
        for name, clock in chosen.items()
        if clock == "header"
    }
    lines = pool({topic: fit_line(*pair, contract) for topic, pair in pairs.items()}, pairs, contract)
    notes = [note for topic, pair in pairs.items() for note in steps(topic, *pair, lines[topic], contract)]
    times: dict[str, Array] = {}
    clocks: dict[str, ClockFit] = {}
    for channel in channels:
        name, clock = channel.name, chosen[channel.name]
        line = lines[samples[name].stream] if clock == "header" else ClockLine(stamps[name].zero, 0.0)
        times[name] = line.to_log(stamps[name].elapsed) - channel.latency
        clocks[name] = _describe(clock, stamps[name], samples[name], line)
    return Aligned(times, clocks, tuple(notes))


def _describe(clock: str, stamps: Stamps, samples: Samples, line: ClockLine) -> ClockFit:
    if clock != "header":
        return ClockFit(clock, 0.0, 0.0, 0.0)
    return describe(clock, stamps.elapsed, samples.stamps["log"].elapsed, line, stamps.zero)


def _stamps(channel: ChannelMap, samples: Samples, clock: str, file: str) -> Stamps:
    if clock not in samples.stamps:
        has = ", ".join(samples.stamps)
        raise DataError(
            f"Channel {channel.name!r} ({channel.source} of {file}) has no {clock} stamps; it has: {has}. "
            "Set its clock to one of these."
        )
    stamps = samples.stamps[clock]
    if len(stamps.elapsed) == 0:
        raise DataError(f"Channel {channel.name!r} ({channel.source} of {file}) has no samples.")
    if len(stamps.elapsed) > 1 and clock != "column" and np.ptp(stamps.elapsed) == 0.0:
        raise DataError(
            f"Channel {channel.name!r} ({channel.source} of {file}): all {clock} stamps are equal, nobody set "
            "them. Choose another clock: header, publish or log."
        )
    return stamps
