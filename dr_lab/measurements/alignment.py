"""All channels of a file on its log clock."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.clocks import ClockLine, describe, fit_line, pool, require_rate, steps
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
        notes: stamps that nobody set, and clocks that do not run straight.
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
    computer's clock: `clocks.fit_line` estimates offset and drift against the log time for each topic, once for those
    that share a clock. The log time stands for header stamps that nobody set.

    Args:
        channels: all channels.
        samples: theirs, by name.
        natural_clock: for channels that name none.
        file: for messages.
        contract: thresholds.

    Raises:
        DataError: a channel has no stamps of its clock, or they do not move or run at another rate.
    """
    chosen = {channel.name: channel.clock or natural_clock for channel in channels}
    stamps = {channel.name: _stamps(channel, samples[channel.name], chosen[channel.name], file) for channel in channels}
    headed = {samples[name].stream: samples[name].stamps for name, clock in chosen.items() if clock == "header"}
    pairs = {topic: _pair(found) for topic, found in headed.items()}
    lines = _lines(pairs, contract)
    notes = [note for topic, found in headed.items() for note in _unset(topic, found["header"].elapsed)]
    notes += [note for topic, pair in pairs.items() for note in steps(topic, *pair, lines[topic], contract)]
    times, clocks = dict[str, Array](), dict[str, ClockFit]()
    for channel in channels:
        name, clock = channel.name, chosen[channel.name]
        time, clocks[name] = stamps[name].elapsed + stamps[name].zero, ClockFit(clock, 0.0, 0.0, 0.0)
        if clock == "header":
            line, both = lines[samples[name].stream], samples[name].stamps
            time = np.where(np.isnan(time), both["log"].elapsed, line.to_log(stamps[name].elapsed))
            clocks[name] = describe(clock, *_pair(both), line, stamps[name].zero)
        times[name] = time - channel.latency
    return Aligned(times, clocks, tuple(notes))


def _lines(pairs: Mapping[str, tuple[Array, Array]], contract: DataContract) -> dict[str, ClockLine]:
    """How the clock of each topic's header stamps runs against the log's."""
    for topic, pair in pairs.items():
        require_rate(topic, *pair, contract)
    return pool({topic: fit_line(*pair, contract) for topic, pair in pairs.items()}, pairs, contract)


def _pair(stamps: Mapping[str, Stamps]) -> tuple[Array, Array]:
    """Header stamps that somebody set, and the log times of the same messages."""
    known = np.isfinite(stamps["header"].elapsed)
    return stamps["header"].elapsed[known], stamps["log"].elapsed[known]


def _unset(topic: str, elapsed: Array) -> list[Note]:
    count = int(np.isnan(elapsed).sum())
    if count == 0:
        return []
    message = f"{topic}: {count} of {len(elapsed)} header stamps are 0, nobody set them; the log time stands for them."
    return [Note("unset_stamps", "", message, count)]


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
    if clock != "column" and _stands(stamps):
        others = [other for other, each in samples.stamps.items() if other != clock and not _stands(each)]
        remedy = (
            f"Choose another clock: {' or '.join(others)}" if others else "Record it again, or leave it out of logs"
        )
        raise DataError(
            f"Channel {channel.name!r} ({channel.source} of {file}): all {clock} stamps are equal, nobody set them. "
            f"{remedy}."
        )
    if clock == "header" and _stands(samples.stamps["log"]):
        raise DataError(
            f"Channel {channel.name!r} ({channel.source} of {file}): all log times are equal, nobody set them, so that "
            "header stamps have no place on the log's clock. Write the file again with log times, e.g. the header's."
        )
    return stamps


def _stands(stamps: Stamps) -> bool:
    return len(stamps.elapsed) > 1 and float(np.ptp(stamps.elapsed)) == 0.0
