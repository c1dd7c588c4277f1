"""ROS 2 messages as bytes: schema texts and CDR encoding of the three message types dr_lab writes.

A block of n messages of one topic is encoded at once: all of them share one layout, so the bytes are one numpy
array of shape (n, size) in which only the time stamp and the numbers differ from row to row.

CDR (OMG DDS-XTypes 1.3, section 7.4, "plain CDR version 1", little endian): four bytes of encapsulation header,
then the fields in order; every number is aligned to its own size counted from the end of that header; a string is
its length with the closing NUL (uint32), then the characters; a sequence is its count (uint32), then the entries.

Decoding is the MCAP reader's job (`dr_lab.measurements.mcap`), which takes any message type.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
NANOSECONDS = 1_000_000_000

_ENCAPSULATION = bytes((0, 1, 0, 0))
_RULE = "=" * 80

_TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
_HEADER = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
_LAYOUT = "MSG: std_msgs/MultiArrayLayout\nstd_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n"
_DIMENSION = "MSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n"


@dataclass(frozen=True)
class MessageType:
    """A ROS 2 message type as an MCAP schema.

    Attributes:
        name: full type name, e.g. ``"std_msgs/msg/Float64"``.
        text: its definition followed by those of its parts (MCAP schema encoding ``ros2msg``).
    """

    name: str
    text: str


JOINT_STATE = MessageType(
    "sensor_msgs/msg/JointState",
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    f"{_RULE}\n{_HEADER}{_RULE}\n{_TIME}",
)
FLOAT64_MULTI_ARRAY = MessageType(
    "std_msgs/msg/Float64MultiArray",
    f"std_msgs/MultiArrayLayout layout\nfloat64[] data\n{_RULE}\n{_LAYOUT}{_RULE}\n{_DIMENSION}",
)
FLOAT64 = MessageType("std_msgs/msg/Float64", "float64 data\n")


class _Layout:
    """Bytes of a message in the making: constant fields as they are, varying columns as (offset, block)."""

    def __init__(self) -> None:
        self._constant = bytearray()
        self._columns: list[tuple[int, Bytes]] = []

    def _align(self, size: int) -> None:
        self._constant.extend(bytes(-len(self._constant) % size))

    def uint32(self, value: int) -> None:
        self._align(4)
        self._constant.extend(value.to_bytes(4, "little"))

    def string(self, text: str) -> None:
        raw = text.encode() + b"\0"
        self.uint32(len(raw))
        self._constant.extend(raw)

    def column(self, block: Bytes, alignment: int) -> None:
        self._align(alignment)
        self._columns.append((len(self._constant), block))
        self._constant.extend(bytes(block.shape[1]))

    def doubles(self, values: NDArray[np.float64] | None) -> None:
        """A float64 sequence per message, shape (n, k); an absent one is a sequence of length zero."""
        if values is None or values.shape[1] == 0:
            self.uint32(0)
            return
        self.uint32(values.shape[1])
        self.column(np.ascontiguousarray(values, dtype="<f8").view(np.uint8), alignment=8)

    def rows(self, count: int) -> Bytes:
        constant = np.frombuffer(_ENCAPSULATION + bytes(self._constant), dtype=np.uint8)
        rows = np.tile(constant, (count, 1))
        for offset, block in self._columns:
            start = len(_ENCAPSULATION) + offset
            rows[:, start : start + block.shape[1]] = block
        return rows


def encode_joint_states(
    stamp_ns: NDArray[np.int64],
    names: Sequence[str],
    position: NDArray[np.float64],
    velocity: NDArray[np.float64] | None = None,
    effort: NDArray[np.float64] | None = None,
) -> Bytes:
    """Encode n ``sensor_msgs/msg/JointState`` messages.

    Args:
        stamp_ns: header stamps in ns, shape (n,).
        names: k joint names.
        position: rad or m, shape (n, k).
        velocity: rad/s or m/s, shape (n, k); None leaves the field empty.
        effort: N·m or N, shape (n, k); None leaves the field empty.

    Returns:
        One message per row, shape (n, size).
    """
    seconds, nanoseconds = np.divmod(stamp_ns, NANOSECONDS)
    stamp = np.stack([seconds.astype("<i4").view("<u4"), nanoseconds.astype("<u4")], axis=1)
    layout = _Layout()
    layout.column(stamp.view(np.uint8), alignment=4)
    layout.string("")
    layout.uint32(len(names))
    for name in names:
        layout.string(name)
    for values in (position, velocity, effort):
        layout.doubles(values)
    return layout.rows(len(stamp_ns))


def encode_float_arrays(labels: Sequence[str], data: NDArray[np.float64]) -> Bytes:
    """Encode n ``std_msgs/msg/Float64MultiArray`` messages of one dimension.

    Args:
        labels: k names of the entries; they travel, joined by commas, as the label of the only dimension.
        data: shape (n, k).

    Returns:
        One message per row, shape (n, size).
    """
    width = data.shape[1]
    layout = _Layout()
    layout.uint32(1)
    layout.string(",".join(labels))
    layout.uint32(width)
    layout.uint32(width)
    layout.uint32(0)
    layout.doubles(data)
    return layout.rows(len(data))


def encode_floats(data: NDArray[np.float64]) -> Bytes:
    """Encode n ``std_msgs/msg/Float64`` messages.

    Args:
        data: shape (n,).

    Returns:
        One message per row, shape (n, 12).
    """
    layout = _Layout()
    layout.column(np.ascontiguousarray(data, dtype="<f8")[:, None].view(np.uint8), alignment=8)
    return layout.rows(len(data))
