"""MCAP files that ROS 2 tools, Foxglove, PlotJuggler and Rerun open: profile ``ros2``, CDR messages."""

import io
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray

from dr_lab.errors import DataError
from dr_lab.files import write_bytes
from dr_lab.ros2 import (
    FLOAT64_MULTI_ARRAY,
    JOINT_STATE,
    NANOSECONDS,
    Bytes,
    MessageType,
    encode_float_arrays,
    encode_joint_states,
)
from dr_lab.trajectory import Array

# Largest times in s: MCAP's fit into 63 bits of nanoseconds here, a header's seconds have 31 bits and a sign.
_LATEST, _LATEST_STAMP = (2**63 - 1) / NANOSECONDS, 2**31 - 1
# A reader that recovers a cut file loses at most one chunk; below 64 KiB compression and seeking get worse.
_CHUNK_BYTES = 128 * 1024


@dataclass(frozen=True)
class JointStates:
    """One topic of ``sensor_msgs/msg/JointState``.

    Attributes:
        topic: e.g. ``"/real/joint_states"``.
        names: k joint names.
        stamp: header stamps in s, shape (n,).
        log_time: when each message was recorded in s, shape (n,); also its publish time.
        position: rad or m, shape (n, k).
        velocity: rad/s or m/s, shape (n, k), or None.
        effort: N·m or N, shape (n, k), or None.
    """

    topic: str
    names: tuple[str, ...]
    stamp: Array
    log_time: Array
    position: Array
    velocity: Array | None = None
    effort: Array | None = None


@dataclass(frozen=True)
class FloatArrays:
    """One topic of ``std_msgs/msg/Float64MultiArray``, a message type without a header.

    Attributes:
        topic: e.g. ``"/command"``.
        labels: k names of the entries, written into the message's layout.
        log_time: when each message was recorded in s, shape (n,).
        data: shape (n, k).
        publish_time: when each message was sent in s, shape (n,); None means the log time.
    """

    topic: str
    labels: tuple[str, ...]
    log_time: Array
    data: Array
    publish_time: Array | None = None


@dataclass(frozen=True)
class _Encoded:
    topic: str
    type: MessageType
    log_time: NDArray[np.int64]
    publish_time: NDArray[np.int64]
    rows: Bytes


def write_mcap(
    path: Path,
    topics: Sequence[JointStates | FloatArrays],
    attachments: Mapping[str, bytes],
    metadata: Mapping[str, str],
) -> None:
    """Write one MCAP file, atomically, messages of all topics merged in the order of their log time.

    What has the same topic, as pieces of a recording, shares one channel.

    Args:
        path: the file to write.
        topics: what to write; times in s become integer nanoseconds.
        attachments: files to carry along by name, e.g. the model's XML.
        metadata: key–value pairs of the record named ``"dr_lab"``, e.g. run id and schema version.

    Raises:
        DataError: the shapes of a topic disagree, a time is not finite or too far from 0, or a log or publish
            time lies before 0.
        DrLabError: the file cannot be written.
    """
    encoded = [_encode(topic) for topic in topics]
    write_bytes(path, _container(encoded, attachments, metadata))


def _container(encoded: Sequence[_Encoded], attachments: Mapping[str, bytes], metadata: Mapping[str, str]) -> bytes:
    buffer = io.BytesIO()
    writer = Writer(buffer, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
    writer.start(profile="ros2", library="dr_lab")
    writer.add_metadata("dr_lab", dict(metadata))
    _write_messages(writer, encoded)
    for name, data in attachments.items():
        media_type = "application/xml" if name.endswith(".xml") else "application/octet-stream"
        writer.add_attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)
    writer.finish()
    return buffer.getvalue()


def _write_messages(writer: Writer, encoded: Sequence[_Encoded]) -> None:
    kinds = {part.topic: part.type for part in encoded}
    schemas = {
        kind: writer.register_schema(kind.name, "ros2msg", kind.text.encode()) for kind in dict.fromkeys(kinds.values())
    }
    channels = {
        topic: writer.register_channel(topic, "cdr", schemas[kind], metadata={"offered_qos_profiles": ""})
        for topic, kind in kinds.items()
    }
    if not encoded:
        return
    source = np.repeat(np.arange(len(encoded)), [len(part.log_time) for part in encoded])
    row = np.concatenate([np.arange(len(part.log_time)) for part in encoded])
    sequence = {topic: itertools.count() for topic in kinds}
    order = np.argsort(np.concatenate([part.log_time for part in encoded]), kind="stable")
    for k, i in zip(source[order].tolist(), row[order].tolist(), strict=True):
        part = encoded[k]
        writer.add_message(
            channel_id=channels[part.topic],
            log_time=int(part.log_time[i]),
            publish_time=int(part.publish_time[i]),
            sequence=next(sequence[part.topic]),
            data=part.rows[i].tobytes(),
        )


def _encode(topic: JointStates | FloatArrays) -> _Encoded:
    if isinstance(topic, JointStates):
        fields = {"position": topic.position, "velocity": topic.velocity, "effort": topic.effort}
        _check(topic.topic, topic.log_time, len(topic.names), fields, {"stamp": topic.stamp})
        log_time = _nanoseconds(topic.log_time)
        rows = encode_joint_states(_nanoseconds(topic.stamp), topic.names, topic.position, topic.velocity, topic.effort)
        return _Encoded(topic.topic, JOINT_STATE, log_time, log_time, rows)
    publish_time = topic.log_time if topic.publish_time is None else topic.publish_time
    _check(topic.topic, topic.log_time, len(topic.labels), {"data": topic.data}, {"publish_time": publish_time})
    rows = encode_float_arrays(topic.labels, topic.data)
    return _Encoded(topic.topic, FLOAT64_MULTI_ARRAY, _nanoseconds(topic.log_time), _nanoseconds(publish_time), rows)


def _nanoseconds(seconds: Array) -> NDArray[np.int64]:
    return np.rint(np.asarray(seconds, dtype=np.float64) * NANOSECONDS).astype(np.int64)


def _check(
    topic: str, log_time: Array, width: int, fields: Mapping[str, Array | None], times: Mapping[str, Array]
) -> None:
    count = len(log_time)
    for name, time in {"log_time": log_time, **times}.items():
        if np.shape(time) != (count,) or not np.isfinite(time).all():
            raise DataError(f"Topic {topic!r}: {name} must be {count} finite times; got shape {np.shape(time)}.")
        latest = _LATEST_STAMP if name == "stamp" else _LATEST
        if np.max(np.abs(time), initial=0.0) >= latest:
            far = np.max(np.abs(time))
            raise DataError(
                f"Topic {topic!r}: {name} lies up to {far:.6g} s from 0; expected less than {latest:.6g} s. Cut such "
                "stamps off, e.g. with time.start and time.stop of the measurements."
            )
        if name != "stamp" and np.min(time, initial=0.0) < 0:
            raise DataError(f"Topic {topic!r}: {name} begins at {np.min(time):g} s; MCAP has no times before 0 s.")
    for name, values in fields.items():
        if values is not None and np.shape(values) != (count, width):
            expected = f"({count}, {width}) (messages, names)"
            raise DataError(f"Topic {topic!r}: {name} must have shape {expected}; got {np.shape(values)}.")
