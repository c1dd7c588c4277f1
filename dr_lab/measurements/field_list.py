"""All numeric fields of decoded ROS 2 messages, as the paths that `field_path.extract` reads."""

from collections.abc import Iterator
from typing import NamedTuple

import pyarrow as pa

from dr_lab.measurements.field_path import labels_of

_STAMPS = ("header", "stamp", "layout")  # no measured quantities
# Types whose messages are pictures, scans and texts, which may fill gigabytes.
BULKY = {
    *(f"sensor_msgs/msg/{name}" for name in ("Image", "CompressedImage", "PointCloud2", "LaserScan", "CameraInfo")),
    *(
        "nav_msgs/msg/OccupancyGrid",
        "rcl_interfaces/msg/Log",
        "tf2_msgs/msg/TFMessage",
        "foxglove_msgs/msg/CompressedVideo",
    ),
    *("visualization_msgs/msg/MarkerArray", "theora_image_transport/msg/Packet"),
}
_LONGEST = 64  # entries; longer lists are images or scans


class Field(NamedTuple):
    """One number of every message.

    Attributes:
        path: e.g. ``"position[arm]"`` or ``"actual.positions[0]"``.
        label: the name of a list's entry, such as a joint's; empty where it has none.
    """

    path: str
    label: str


def numeric_fields(messages: pa.StructArray) -> Iterator[Field]:
    """The numeric fields of a topic, entries of lists one by one.

    Lists whose length changes are left out, unless names beside them tell their entries.

    Args:
        messages: one struct per message.
    """
    yield from _fields(messages, "", [])


def _fields(array: pa.Array, path: str, names: list[str]) -> Iterator[Field]:
    if pa.types.is_struct(array.type):
        beside = _names(array)
        for field in array.type:
            if field.name not in _STAMPS:
                below = f"{path}.{field.name}" if path else field.name
                yield from _member(array.field(field.name), below, beside or names, named=bool(beside))
    elif _is_number(array.type):
        yield Field(path, "")


def _member(array: pa.Array, path: str, names: list[str], *, named: bool) -> Iterator[Field]:
    if not pa.types.is_list(array.type):
        yield from _fields(array, path, names)
        return
    lengths = set(array.value_lengths().to_pylist()) - {0, None}
    if not _is_number(array.type.value_type) or not lengths or max(lengths) > _LONGEST:
        return
    if named:
        yield from (Field(f"{path}[{name}]", name) for name in names)
    elif len(lengths) == 1:
        count = lengths.pop()
        told = names if len(names) == count else [""] * count
        yield from (Field(f"{path}[{k}]", label) for k, label in enumerate(told))


def _names(array: pa.StructArray) -> list[str]:
    """Names of the entries of the lists in a message, of all messages together."""
    strings = [f.name for f in array.type if pa.types.is_list(f.type) and pa.types.is_string(f.type.value_type)]
    if not strings:
        return labels_of(array)
    return [name for name in array.field(strings[0]).flatten().unique().to_pylist() if name and "]" not in name]


def _is_number(kind: pa.DataType) -> bool:
    return pa.types.is_floating(kind) or pa.types.is_integer(kind)
