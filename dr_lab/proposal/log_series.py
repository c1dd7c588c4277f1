"""The numbers of a log, place by place, as they are before anything is known of them, and what is unsure of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.measurements.cleaning import Cleaned, drop_not_finite, drop_unordered
from dr_lab.measurements.inventory import Place
from dr_lab.measurements.raw_log import RawChannel, TimeAxis, read_raw
from dr_lab.measurements.recordings import Recording
from dr_lab.measurements.signal_map import ChannelMap, channel_map
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.trajectory import Array, Signal


@dataclass(frozen=True)
class LogSeries:
    """What was read of a log.

    Attributes:
        signals: numbers of every place, however few; None where there are none.
        doubts: what is unsure of them, a sentence each.
    """

    signals: tuple[Signal | None, ...]
    doubts: tuple[str, ...]


def read_series(
    name: str, recording: Recording, places: Sequence[Place], axis: TimeAxis | None, settings: ProposalSettings
) -> LogSeries:
    """Read the numbers of every place in a log.

    Args:
        name: of the log, for messages.
        recording: where it lies.
        places: where it keeps its numbers.
        axis: clock of a table; None of messages.
        settings: thresholds of the data contract.

    Raises:
        DataError: a place cannot be read.
    """
    channels = [_channel(k, place) for k, place in enumerate(places)]
    raw = read_raw(recording, channels, (), axis or TimeAxis(), settings.contract)
    sound = [_sound(channel) for channel in raw.outputs]
    signals = (
        None if s is None else Signal(c.name, "1", s.time, s.value) for c, s in zip(channels, sound, strict=True)
    )
    return LogSeries(tuple(signals), _set_back(name, places, raw.outputs, sound))


def _channel(k: int, place: Place) -> ChannelMap:
    return channel_map(f"sensor.{k}", {**place.entry, "unit": "1"}, place.clock)


def _sound(channel: RawChannel) -> Cleaned | None:
    """Finite numbers in the order of time, with what was found in that order; None where there are none."""
    name = channel.channel.name
    if channel.value.ndim > 1 or not np.isfinite(channel.value).any():
        return None
    finite = drop_not_finite(name, channel.time, channel.value)
    return drop_unordered(name, finite.time, finite.value)


def _set_back(
    log: str, places: Sequence[Place], raw: Sequence[RawChannel], sound: Sequence[Cleaned | None]
) -> tuple[str, ...]:
    """What is said of a table or of topics whose time goes back, so that later samples lie before earlier ones."""
    most, told = dict[str, int](), dict[str, str]()
    for place, channel, kept in zip(places, raw, sound, strict=True):
        lost = sum(note.count for note in kept.notes if note.kind == "back_steps") if kept else 0
        if lost > most.get(place.topic, 0):
            most[place.topic], told[place.topic] = lost, _said(log, place.topic, channel.time, lost)
    return tuple(told.values())


def _said(log: str, topic: str, time: Array, lost: int) -> str:
    times = int((np.diff(time[np.isfinite(time)]) < 0).sum())
    what, rows = (f"the time of {topic}", "messages") if topic else ("the time", "rows")
    remedy = (
        "Use clock: log, or cut the log there."
        if topic
        else "If they are several runs, add a column that numbers them, or give each a file of its own."
    )
    return (
        f"{log}: {what} goes back {times} time{'s' * (times != 1)}; {lost} of {len(time)} {rows} are left out, as they "
        f"lie before earlier ones. {remedy}"
    )
