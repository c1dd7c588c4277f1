"""All series of numbers of all logs, on each log's clock, as they are before anything is known of them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.cleaning import drop_not_finite, drop_unordered
from dr_lab.measurements.inventory import Place, columns_of, messages_of, require_one_kind
from dr_lab.measurements.raw_log import RawChannel, TimeAxis, read_raw
from dr_lab.measurements.recordings import Recording, recordings
from dr_lab.measurements.signal_map import ChannelMap, channel_map
from dr_lab.measurements.split import find_files
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.time_column import Clock, find_clock
from dr_lab.proposal.words import Words, read_name
from dr_lab.trajectory import Signal


@dataclass(frozen=True)
class Series:
    """One series of numbers in all logs that are looked at.

    Attributes:
        place: where the files keep it.
        words: what its name says.
        signals: raw numbers of each log, in the order of `Survey.names`.
    """

    place: Place
    words: Words
    signals: tuple[Signal, ...]

    @property
    def moves(self) -> bool:
        """Whether its numbers ever change."""
        return any(bool(np.ptp(signal.value) > 0) for signal in self.signals)


@dataclass(frozen=True)
class Survey:
    """What the logs hold.

    Attributes:
        files: all files and folders by name.
        logs: names of all logs.
        looked_at: those of them that `series` shows.
        series: every series of numbers that all those logs hold.
        clock: of tables; None of messages.
    """

    files: dict[str, Path]
    logs: tuple[str, ...]
    looked_at: tuple[str, ...]
    series: tuple[Series, ...]
    clock: Clock | None

    def named(self, kind: str) -> list[Series]:
        """The series whose names say a quantity."""
        return [each for each in self.series if each.words.kind == kind]


def survey(patterns: Sequence[str], settings: ProposalSettings) -> Survey:
    """Read some of the logs, whatever they hold.

    Args:
        patterns: files, bag folders or globs.
        settings: how much is looked at.

    Raises:
        DataError: there are no logs, or none can be read.
        ConfigError: they are of several kinds.
    """
    files = find_files(patterns)
    tables = require_one_kind(list(files.values()))
    clock = find_clock(next(iter(files.values()))) if tables else None
    known = recordings(files, clock.group if clock else None)
    chosen = [list(known)[k] for k in _spread(len(known), settings.logs)]
    places = _common([columns_of(known[name].path) if tables else messages_of(known[name].path) for name in chosen])
    if clock is not None:
        places = [place for place in places if place.path not in (clock.axis.column, clock.group)]
    if not places:
        raise DataError(f"{chosen[0]} holds no numbers beside its clock. Name another log.")
    read = [_series(known[name], places, clock, settings) for name in chosen]
    usable = [k for k, _ in enumerate(places) if all(log[k] is not None for log in read)]
    series = tuple(_named(places[k], tuple(s for log in read if (s := log[k]) is not None)) for k in usable)
    return Survey(files, tuple(known), tuple(chosen), series, clock)


def _named(place: Place, signals: tuple[Signal, ...]) -> Series:
    return Series(place, read_name(place.topic, place.path, place.label), signals)


def _spread(count: int, most: int) -> list[int]:
    """At most so many places, from the first to the last."""
    return sorted({int(k) for k in np.linspace(0, count - 1, min(count, most))})


def _common(found: Sequence[Sequence[Place]]) -> list[Place]:
    """The places that all logs have, in the order of the first."""
    held = Counter(str(place) for places in found for place in {*places})
    return [place for place in found[0] if held[str(place)] == len(found)]


def _series(
    recording: Recording, places: Sequence[Place], clock: Clock | None, settings: ProposalSettings
) -> list[Signal | None]:
    """Numbers of every place in one log; None where there are too few."""
    channels = [_channel(k, place) for k, place in enumerate(places)]
    raw = read_raw(recording, channels, (), clock.axis if clock else TimeAxis(), settings.contract)
    return [_sound(channel, settings) for channel in raw.outputs]


def _channel(k: int, place: Place) -> ChannelMap:
    return channel_map(f"sensor.{k}", {**place.entry, "unit": "1"}, place.clock)


def _sound(channel: RawChannel, settings: ProposalSettings) -> Signal | None:
    name = channel.channel.name
    if channel.value.ndim > 1 or not np.isfinite(channel.value).any():
        return None
    finite = drop_not_finite(name, channel.time, channel.value)
    ordered = drop_unordered(name, finite.time, finite.value)
    few = len(ordered.time) < settings.contract.minimum_samples
    return None if few else Signal(name, "1", ordered.time, ordered.value)
