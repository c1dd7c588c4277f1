"""What of messages can be read: a field or a topic that cannot does not hide the others."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.alignment import align
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.inventory import Place
from dr_lab.measurements.raw_log import TimeAxis, open_source
from dr_lab.measurements.recordings import Recording
from dr_lab.measurements.samples import Samples, SampleSource
from dr_lab.measurements.signal_map import ChannelMap, channel_map


@dataclass(frozen=True)
class Readable:
    """What some logs let read.

    Attributes:
        places: those that can be read in every log, with the clock that can be used in every log.
        doubts: what cannot be read, and which header stamps cannot be used, a sentence or more each.
    """

    places: tuple[Place, ...]
    doubts: tuple[str, ...]


def readable(logs: Sequence[Recording], places: Sequence[Place], contract: DataContract) -> Readable:
    """Try every field, then the stamps of every topic; the log time stands for header stamps that cannot be used.

    Args:
        logs: files and bags of messages.
        places: fields that all of them hold, topic by topic.
        contract: thresholds.

    Raises:
        DataError: a log cannot be opened, or nothing is left.
    """
    doubts: list[str] = []
    for recording in logs:
        source, left = open_source(recording, TimeAxis()), list[Place]()
        for _, fields in groupby(places, key=lambda place: place.topic):
            samples, unread = _samples(source, [*fields])
            found, unused = _timed(samples, source.natural_clock, recording.path.name, contract)
            left += found
            doubts += [*unread, *unused]
        if not left:
            raise DataError(f"{recording.path.name} holds no field that can be read. {' '.join(doubts)}")
        places = left
    return Readable(tuple(places), tuple(doubts))


def _samples(source: SampleSource, fields: Sequence[Place]) -> tuple[dict[Place, Samples], list[str]]:
    """The samples of the fields of a topic that can be read, and what is said of the others."""
    found, lost = dict[Place, Samples](), dict[Place, str]()
    for place in fields:
        try:
            found[place] = source.samples(_channel(place))
        except (DataError, UnknownNameError) as error:
            lost[place] = str(error)
    said = f"{', '.join(map(str, lost))} {'is' if len(lost) == 1 else 'are'} not read: {next(iter(lost.values()), '')}"
    return found, [said] if lost else []


def _timed(
    samples: Mapping[Place, Samples], natural_clock: str, file: str, contract: DataContract
) -> tuple[list[Place], list[str]]:
    """The fields of a topic with a clock that can be used, and what is said of stamps that cannot."""
    places = [*samples]
    refused = _refusal(places, samples.values(), natural_clock, file, contract)
    if not refused:
        return places, []
    topic, logged = places[0].topic, [replace(place, clock="log") for place in places]
    if again := _refusal(logged, samples.values(), natural_clock, file, contract):
        return [], [f"{topic} is not read: {again}"]
    enough = max(len(each.value) for each in samples.values()) >= contract.minimum_samples
    return logged, [f"{topic}: the log time stands for its header stamps. {refused}"] if enough else []


def _refusal(
    places: Sequence[Place], samples: Iterable[Samples], natural_clock: str, file: str, contract: DataContract
) -> str:
    """Why stamps cannot be used; empty where they can."""
    named = {str(place): each for place, each in zip(places, samples, strict=True)}
    try:
        align([_channel(place) for place in places], named, natural_clock, file, contract)
    except DataError as error:
        return str(error)
    return ""


def _channel(place: Place) -> ChannelMap:
    """Called as its place is, for messages."""
    return replace(channel_map("sensor", {**place.entry, "unit": "1"}, place.clock), name=str(place))
