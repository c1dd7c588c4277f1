"""MCAP logs of ROS 2: any numeric field of any topic, with the header's, the publisher's and the recorder's time.

Messages are decoded by Rerun's reader into Arrow arrays, a whole topic at a time.
"""

import re
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from rerun.chunk import McapReader

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.field_list import BULKY, Field, numeric_fields
from dr_lab.measurements.field_path import Rows, extract
from dr_lab.measurements.mcap_chunks import damaged_chunks
from dr_lab.measurements.samples import Samples, Stamps, combine
from dr_lab.measurements.signal_map import ChannelMap, names_of
from dr_lab.trajectory import Array, Note

_DECODER = "ros2_reflection"
_CLOCK_COLUMNS = {"log": "message_log_time", "publish": "message_publish_time", "header": "ros2_timestamp"}
_NANO = 1e-9
# A header stamp of 0 is taken for one that nobody set, unless a clock that runs as the others' passes through 0 there
# (a simulator's first message): its delay to the log differs from the usual one by less than this many ns.
_STARTS = 1_000_000_000


class Topic(NamedTuple):
    """The messages of a topic, the times of each clock in ns, and their type."""

    messages: pa.StructArray
    stamps: dict[str, NDArray[np.int64]]
    kind: str


class McapSource:
    """An MCAP file; a cut one is recovered as far as its messages are complete.

    Times count from the log time of the file's first message, and within the header's clock from the header stamp
    first read of a topic that has any. A header stamp of 0 that its clock does not pass through is one that nobody set.

    Args:
        path: the file.
        origin: the log whose messages it holds, for messages to the user; None is the file itself.

    Raises:
        DataError: empty, not an MCAP, cut before its first message, or without messages.
    """

    natural_clock = "log"

    def __init__(self, path: Path, origin: Path | None = None) -> None:
        self._path = path
        self._origin = origin or path
        self._recover = False
        self._header_zero: int | None = None
        self._topics: dict[str, Topic] = {}
        self._info = self._inspect()
        if self._info.message_count == 0 and self._recover:
            raise DataError(f"{self._origin} is cut before its first message was complete. Leave it out of logs.")
        if self._info.message_count == 0:
            raise DataError(self._without_messages())

    def _without_messages(self) -> str:
        return f"{self._origin} holds no messages. Record it again, or leave it out of logs."

    @property
    def name(self) -> str:
        """Of the log's file or folder."""
        return self._origin.name

    @property
    def notes(self) -> tuple[Note, ...]:
        """Whether the file was cut, and what survived; messages of the topics read so far that could not be decoded."""
        notes = []
        if self._recover:
            count = self._info.message_count
            message = f"{self.name} ends early (interrupted recording); {count} complete messages were recovered."
            notes.append(Note("cut", "", message, count))
        for name, topic in self._topics.items():
            count = sum(channel.message_count for channel in self._channels[name])
            if lost := count - len(topic.messages):
                message = f"{lost} of {count} messages of {name} could not be decoded and were left out."
                notes.append(Note("undecoded", "", message, lost))
        return tuple(notes)

    @property
    def topics(self) -> tuple[str, ...]:
        """Of all messages, by name."""
        return tuple(sorted(self._channels))

    def fields(self, topic: str) -> tuple[Field, ...]:
        """The numeric fields of a topic; none where its messages cannot be decoded, or are pictures and the like.

        Raises:
            UnknownNameError: no such topic; the message lists those there are.
        """
        schema = self._channels[topic][0].schema if topic in self._channels else None
        if schema is not None and schema.name in BULKY:
            return ()
        try:
            return tuple(numeric_fields(self._topic(topic).messages))
        except DataError:
            return ()

    def stamped(self, topic: str) -> bool:
        """Whether somebody set the header stamps of a topic that can be decoded."""
        stamps = self._topic(topic).stamps.get("header")
        return stamps is not None and bool(stamps.any())

    def rows(self, topic: str) -> Array:
        """All entries of a topic of ``std_msgs/msg/Float64MultiArray``, message by message, shape (n, k).

        Raises:
            UnknownNameError: no such topic; the message lists those there are.
            DataError: its messages are damaged, of another type, or of different lengths.
        """
        found = self._topic(topic)
        where = f"Topic {topic!r} ({found.kind}) of {self.name}"
        kind = found.messages.type
        if "data" not in kind.names or not pa.types.is_list(kind.field("data").type):
            raise DataError(f"{where} holds no arrays; expected std_msgs/msg/Float64MultiArray.")
        data = found.messages.field("data")
        lengths = set(data.value_lengths().to_pylist())
        if len(lengths) != 1:
            raise DataError(f"{where} holds arrays of {len(lengths)} different lengths; expected one.")
        return data.flatten().to_numpy().reshape(len(data), lengths.pop())

    def samples(self, channel: ChannelMap) -> Samples:
        """Read one channel.

        Raises:
            UnknownNameError: no such topic, field or joint; the message lists those there are.
            DataError: a topic that is damaged or cannot be decoded, or a field that holds no numbers.
        """
        if not channel.topic:
            raise DataError(
                f"Channel {channel.name!r} names a column, but {self.name} is an MCAP file. "
                "Write topic: NAME and field: PATH instead."
            )
        topic = self._topic(channel.topic)
        where = f"topic {channel.topic!r} ({topic.kind}) of {self.name}"
        found = {name: extract(topic.messages, name, where) for name in names_of(channel.readings)}
        rows = _common([part.rows for part in found.values()])
        parts = {name: part.value[np.searchsorted(part.rows, rows)] for name, part in found.items()}
        missing = len(topic.messages) - len(rows)
        chosen = {clock: ns[rows] for clock, ns in topic.stamps.items()}
        start = int(self._info.message_start_time_ns)
        stamps = {
            clock: self._header(ns, chosen["log"]) if clock == "header" else Stamps(_seconds(ns, start), zero=0.0)
            for clock, ns in chosen.items()
        }
        return Samples(combine(channel, parts.__getitem__), stamps, channel.topic, missing)

    def _inspect(self) -> Any:  # noqa: ANN401  (the class is private to Rerun)
        if self._path.stat().st_size == 0:
            raise DataError(f"{self._origin} is empty (0 bytes). Record it again, or leave it out of logs.")
        try:
            return self._reader().info()
        except ValueError as error:
            if "start magic" in str(error):
                raise DataError(
                    f"{self._origin} is not an MCAP file: it does not start with MCAP's magic bytes. "
                    "Name another file in logs; convert a ROS 1 bag with the mcap tool."
                ) from error
        self._recover = True
        try:
            return self._reader().info()
        except ValueError as error:
            raise DataError(
                f"{self._origin} is damaged and nothing in it could be recovered: {error}. Leave it out of logs."
            ) from error

    def _batches(self, topic: str) -> list[pa.RecordBatch]:
        damaged, count = (0, 0) if self._recover else damaged_chunks(self._path, topic)
        if damaged:
            raise self._damaged(f"{damaged} of {count} chunks with {topic} are not as they were written")
        try:
            return [chunk.to_record_batch() for chunk in self._reader(topic).stream()]
        except RuntimeError as error:  # Rerun's, followed by its own backtrace
            raise self._damaged(str(error).splitlines()[0].rstrip(" :")) from error

    def _damaged(self, reason: str) -> DataError:
        return DataError(
            f"{self._origin} is damaged ({reason}). Copy it again, mend it with mcap recover, or leave it out of logs."
        )

    def _reader(self, topic: str | None = None) -> McapReader:
        chosen = None if topic is None else [f"^{re.escape(topic)}$"]
        return McapReader(self._path, decoders=[_DECODER], include_topic_regex=chosen, recover=self._recover)

    @cached_property
    def _channels(self) -> dict[str, list[Any]]:
        """The channels of each topic: a file may give each publisher its own."""
        found: dict[str, list[Any]] = {}
        for channel in self._info.channels:
            found.setdefault(channel.topic, []).append(channel)
        return found

    def _topic(self, name: str) -> Topic:
        if name not in self._topics:
            if name not in self._channels:
                raise UnknownNameError("topic", name, self._channels, self.name)
            self._topics[name] = self._read(name)
        return self._topics[name]

    def _read(self, name: str) -> Topic:
        channels, suffix = self._channels[name], ":message"
        kinds = sorted({channel.schema.name if channel.schema else "no schema" for channel in channels})
        batches = [b for b in self._batches(name) if any(column.endswith(suffix) for column in b.schema.names)]
        if not batches and not any(channel.message_count for channel in channels):
            raise DataError(f"Topic {name!r} of {self.name} has no message. Record it, or leave its channels out.")
        if not batches:
            encoding, schema = channels[0].message_encoding, channels[0].schema
            raise DataError(
                f"Topic {name!r} ({' and '.join(kinds)}) of {self.name} holds no message that can be decoded: "
                f"its encoding is {encoding} with schema {schema.encoding if schema else 'none'}; expected cdr with "
                "schema ros2msg."
            )
        column, *others = {c: None for batch in batches for c in batch.schema.names if c.endswith(suffix)}
        if others:
            raise DataError(
                f"Topic {name!r} of {self.name} holds messages of several types ({', '.join(kinds)}); expected "
                "one. Publish each on a topic of its own, or leave the file out of logs."
            )
        messages = pa.concat_arrays([batch.column(column).flatten() for batch in batches])
        stamps = {
            clock: np.concatenate([batch.column(title).cast(pa.int64()).to_numpy() for batch in batches])
            for clock, title in _CLOCK_COLUMNS.items()
            if all(title in batch.schema.names for batch in batches)
        }
        return _in_log_order(messages, stamps, kinds[0])

    def _header(self, stamped: NDArray[np.int64], log: NDArray[np.int64]) -> Stamps:
        known = _is_set(stamped, log)
        if self._header_zero is None and stamped.any():
            self._header_zero = int(stamped[known][0])
        zero = self._header_zero or 0
        elapsed = np.where(known, _seconds(stamped, zero), np.nan)
        return Stamps(elapsed, zero=(zero - int(self._info.message_start_time_ns)) * _NANO)


def _is_set(stamped: NDArray[np.int64], log: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which header stamps somebody set; all, where all are 0."""
    known = stamped != 0
    if not known.any():
        return ~known
    delay = log - stamped
    usual = int(np.sort(delay[known])[known.sum() // 2])
    return known | (np.abs(delay - usual) < _STARTS)


def _in_log_order(messages: pa.StructArray, stamps: dict[str, NDArray[np.int64]], kind: str) -> Topic:
    """Recorders write what arrives when; chunks may overlap in time."""
    log = stamps["log"]
    if (np.diff(log) >= 0).all():
        return Topic(messages, stamps, kind)
    order = np.argsort(log, kind="stable")
    return Topic(messages.take(pa.array(order)), {clock: ns[order] for clock, ns in stamps.items()}, kind)


def _seconds(nanoseconds: NDArray[np.int64], zero: int) -> Array:
    """Subtract first, in integers: nanoseconds since 1970 have more digits than a float64."""
    return (nanoseconds - zero).astype(np.float64) * _NANO


def _common(rows: list[Rows]) -> Rows:
    common = rows[0]
    for other in rows[1:]:
        common = np.intersect1d(common, other, assume_unique=True)
    return common
