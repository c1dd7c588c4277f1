"""All series of numbers of all logs, on each log's clock, as they are before anything is known of them."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.inventory import Place, columns_of, messages_of, require_one_kind, shared_names
from dr_lab.measurements.recordings import Recording, recordings
from dr_lab.measurements.split import find_files
from dr_lab.measurements.table_file import load
from dr_lab.measurements.text_columns import text_columns
from dr_lab.proposal.log_series import LogSeries, read_series
from dr_lab.proposal.partly_held import partly_held
from dr_lab.proposal.readable import readable
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.time_column import Clock, find_clock
from dr_lab.proposal.words import Words, asked_for, read_name, told_apart
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
        series: every series of numbers that all logs hold which were looked at.
        clock: of tables; None of messages.
        spoilt: what keeps series from being read, a sentence each: text in a column, a name that several columns share,
            a log that lacks them.
        counts: series that count the rows or messages, which are no readings.
        short: logs that hold too few rows or messages to be used, each with what is said of it.
        doubts: what is unsure of the numbers as they were read, a sentence each.
    """

    files: dict[str, Path]
    logs: tuple[str, ...]
    series: tuple[Series, ...]
    clock: Clock | None
    spoilt: tuple[str, ...] = ()
    counts: tuple[Series, ...] = ()
    short: Mapping[str, str] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()

    def named(self, kind: str) -> list[Series]:
        """The series whose names say a quantity."""
        return [each for each in self.series if each.words.kind == kind]


def survey(patterns: Sequence[str], settings: ProposalSettings) -> Survey:
    """Read some of the logs, whatever they hold.

    Args:
        patterns: files, globs, or folders with logs of one kind.
        settings: how much is looked at.

    Raises:
        DataError: there are no logs, or none can be read.
        ConfigError: they are of several kinds.
    """
    files = find_files(patterns)
    tables = require_one_kind(list(files.values()))
    clock = _clock(list(files.values()), settings) if tables else None
    known = recordings(files, clock.group if clock else None)
    short: dict[str, str] = {}
    while True:
        long = [name for name in known if name not in short]
        chosen = [long[k] for k in _spread(len(long), settings.logs)]
        places, read, spoilt, doubts = _read({name: known[name] for name in chosen}, clock, settings)
        few = {name: said for name, log in zip(chosen, read, strict=True) if (said := _too_few(log.signals, settings))}
        if not few:
            break
        short |= few
        _require_long(short, len(known))
    least = settings.contract.minimum_samples
    signals = [[None if s is None or len(s.time) < least else s for s in log.signals] for log in read]
    usable = [k for k, _ in enumerate(places) if all(log[k] is not None for log in signals)]
    paths = [place.path for place in places]
    named = partial(read_name, apart=told_apart(paths), asked_for=asked_for(paths))
    every = [_series(places[k], named, [s for log in signals if (s := log[k]) is not None]) for k in usable]
    counts = tuple(each for each in every if _counts_rows(each))
    series = tuple(each for each in every if not _counts_rows(each))
    doubts = (*doubts, *(said for log in read for said in log.doubts))
    return Survey(files, tuple(known), series, clock, spoilt, counts, short, doubts)


def _counts_rows(series: Series) -> bool:
    """Whether a series without a name that says a quantity rises by the same whole number from row to row, always."""
    if series.words.kind:
        return False
    steps = np.concatenate([np.diff(signal.value) for signal in series.signals])
    whole = all(bool((signal.value == np.round(signal.value)).all()) for signal in series.signals)
    return whole and len(steps) > 0 and bool(steps[0] > 0) and bool((steps == steps[0]).all())


def _spoilt(
    tables: Sequence[Recording], settings: ProposalSettings, held: Mapping[str, Sequence[Place]] | None = None
) -> tuple[str, ...]:
    """What is said of columns that text or a shared name keeps from being read, and of series that some logs lack."""
    paths = dict.fromkeys(recording.path for recording in tables)
    texts = [column for path in paths for column in text_columns(path, settings.text)]
    shared = (said for path in paths for said in shared_names(path))
    return (*map(str, texts), *shared, *partly_held(held or {}, {column.column for column in texts}))


def _clock(tables: Sequence[Path], settings: ProposalSettings) -> Clock:
    """The clock of the first table with enough rows; of the first of all where none has."""
    least = settings.contract.minimum_samples
    path = next((path for path in tables if load(path).table.num_rows >= least), tables[0])
    try:
        return find_clock(path)
    except DataError as error:
        raise DataError(" ".join([str(error), *_spoilt([Recording(path)], settings)])) from error


class _Read(NamedTuple):
    """The places that some logs share, their numbers in each, what is said of others, and what is unsure."""

    places: Sequence[Place]
    logs: list[LogSeries]
    spoilt: tuple[str, ...]
    doubts: tuple[str, ...]


def _read(chosen: Mapping[str, Recording], clock: Clock | None, settings: ProposalSettings) -> _Read:
    """Read what all of some logs hold beside their clock."""
    held = _held(chosen, clock)
    places, spoilt = _common([*held.values()]), _spoilt([*chosen.values()] if clock else (), settings, held)
    if not places:
        empty = next((chosen[name].path.name for name in chosen if not held[name]), None)
        what = (
            f"{empty} holds no numbers beside its clock." if empty else "The logs have no series of numbers in common."
        )
        raise DataError(f"{what} {' '.join(spoilt) or 'Name another log.'}")
    axis = clock.axis if clock else None

    def numbers(of: Sequence[Place]) -> list[LogSeries]:
        return [read_series(name, recording, of, axis, settings) for name, recording in chosen.items()]

    try:
        return _Read(places, numbers(places), spoilt, ())
    except (DataError, UnknownNameError):
        if clock:
            raise
    found = readable([*chosen.values()], places, settings.contract)
    return _Read(found.places, numbers(found.places), spoilt, found.doubts)


def _held(chosen: Mapping[str, Recording], clock: Clock | None) -> dict[str, Sequence[Place]]:
    """By log, what it holds beside its clock."""
    if clock is None:
        return {name: messages_of(recording.path) for name, recording in chosen.items()}
    beside = (clock.axis.column, clock.group)
    return {
        name: [place for place in columns_of(recording.path) if place.path not in beside]
        for name, recording in chosen.items()
    }


def _too_few(log: Sequence[Signal | None], settings: ProposalSettings) -> str:
    """What is said of a log none of whose series has enough samples; empty of one that has such a series."""
    most, least = max((len(s.time) for s in log if s is not None), default=0), settings.contract.minimum_samples
    return "" if most >= least else f"It holds {most} row{'s' * (most != 1)} of numbers; expected at least {least}."


def _require_long(short: Mapping[str, str], logs: int) -> None:
    """Refuse logs of which none is long enough."""
    if len(short) == logs:
        listed = " ".join(f"{name}: {said}" for name, said in short.items())
        raise DataError(f"Each log is too short. {listed} Record for longer or at a higher rate, or name other logs.")


def _series(place: Place, named: Callable[[str, str, str], Words], signals: Sequence[Signal]) -> Series:
    return Series(place, named(place.topic, place.path, place.label), tuple(signals))


def _spread(count: int, most: int) -> list[int]:
    """At most so many places, from the first to the last."""
    return sorted({int(k) for k in np.linspace(0, count - 1, min(count, most))})


def _common(found: Sequence[Sequence[Place]]) -> list[Place]:
    """The places that all logs have, in the order of the first."""
    held = Counter(str(place) for places in found for place in {*places})
    return [place for place in found[0] if held[str(place)] == len(found)]
