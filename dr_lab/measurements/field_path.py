"""Numeric fields of decoded ROS 2 messages by path, on whole Arrow arrays at once."""

import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.trajectory import Array

Rows = NDArray[np.intp]

_STEP = re.compile(r"(?P<dot>^|\.)(?P<name>[A-Za-z_]\w*)|\[(?P<key>[^\]]+)\]")


class Found(NamedTuple):
    """A field's numbers.

    Attributes:
        value: shape (m,), or (m, k) for a field that is itself a list of k numbers.
        rows: which messages hold it, shape (m,), increasing.
    """

    value: Array
    rows: Rows


def extract(messages: pa.StructArray, path: str, where: str) -> Found:
    """Read one field of every message.

    ``a.b`` descends into a message, ``a[2]`` takes an entry of a list, ``position[arm]`` the entry whose name is
    ``arm``, and ``position[2]`` that whose name is ``2`` if there is one. Names come from a list of strings beside the
    list (JointState's ``name``), or from the label of the only dimension of a Float64MultiArray. Messages that do not
    hold the entry are left out.

    Args:
        messages: one struct per message.
        path: e.g. ``"position[arm]"``, ``"data[0]"``, ``"twist.linear.x"``.
        where: what the messages are, for error messages.

    Raises:
        UnknownNameError: no such field or entry; the message lists those there are.
        DataError: the path is malformed, leads to something that is not a number, or to an index out of range.
    """
    array: pa.Array = messages
    rows: Rows = np.arange(len(messages))
    parent, parent_name = messages, ""
    for step in _steps(path, where):
        if isinstance(step, tuple):
            array, rows = _entry(array, rows, step[0], parent, f"{where}, field {parent_name!r}")
        else:
            parent, parent_name = array, step
            array = _member(array, step, where)
    return Found(_numbers(array, f"{where}, field {path!r}"), rows)


def _steps(path: str, where: str) -> Iterator[str | tuple[str]]:
    """Names as they are, keys in brackets as one-tuples."""
    end = 0
    while end < len(path):
        match = _STEP.match(path, end)
        if match is None or (end == 0 and match["key"]):
            raise DataError(
                f"{where}: {path!r} is not a field path; write e.g. position[arm], data[0] or twist.linear.x."
            )
        yield (match["key"],) if match["key"] else match["name"]
        end = match.end()


def _member(array: pa.Array, name: str, where: str) -> pa.Array:
    if not pa.types.is_struct(array.type):
        raise DataError(f"{where}: {array.type} has no field {name!r}; lists take an entry in brackets, e.g. [0].")
    names = [field.name for field in array.type]
    if name not in names:
        raise UnknownNameError("field", name, names, where)
    return array.field(name)


def _entry(array: pa.Array, rows: Rows, key: str, parent: pa.Array, where: str) -> tuple[pa.Array, Rows]:
    if not pa.types.is_list(array.type):
        raise DataError(f"{where}: {array.type} is not a list; [{key}] needs one.")
    offsets = array.offsets.to_numpy()
    counts = np.diff(offsets)
    if key.isdecimal() and key not in _names(parent):
        position, held = np.full(len(array), int(key)), np.arange(len(array))
    else:
        position, held = _positions(parent, key, where)
    inside = position < counts[held]
    if len(array) and not inside.any():
        raise DataError(
            f"{where}: no message has an entry [{key}]; their lists have up to {int(counts.max())} entries."
        )
    held, position = held[inside], position[inside]
    return array.values.take(pa.array(offsets[held] + position)), rows[held]


def _positions(parent: pa.StructArray, key: str, where: str) -> tuple[Rows, Rows]:
    """Place of the entry named `key` in each message's list, and the messages that have one."""
    names = _strings_of(parent)
    if names is None:
        labels = labels_of(parent)
        if key not in labels:
            raise UnknownNameError("entry", key, labels or (), where)
        return np.full(len(parent), labels.index(key)), np.arange(len(parent))
    lists = parent.field(names)
    offsets = lists.offsets.to_numpy()
    encoded = lists.values.dictionary_encode()
    available = encoded.dictionary.to_pylist()
    if key not in available:
        raise UnknownNameError("joint", key, available, where)
    flat = np.flatnonzero(encoded.indices.to_numpy() == available.index(key))
    flat = flat[(flat >= offsets[0]) & (flat < offsets[-1])]
    message = np.searchsorted(offsets, flat, side="right") - 1
    message, first = np.unique(message, return_index=True)
    return flat[first] - offsets[message], message


def _names(parent: pa.StructArray) -> list[str]:
    """What entries of lists beside them are called; joints may be called by digits."""
    names = _strings_of(parent)
    return labels_of(parent) if names is None else parent.field(names).flatten().unique().to_pylist()


def _strings_of(parent: pa.StructArray) -> str | None:
    """The list of strings in a message; None if it has none."""
    return next((f.name for f in parent.type if f.type.equals(pa.list_(pa.string())) or _is_strings(f.type)), None)


def _is_strings(kind: pa.DataType) -> bool:
    return pa.types.is_list(kind) and pa.types.is_string(kind.value_type)


def labels_of(parent: pa.StructArray) -> list[str]:
    """Comma-separated label of the first dimension of a Float64MultiArray, of the first message that has one."""
    if "layout" not in [field.name for field in parent.type]:
        return []
    dimensions = parent.field("layout").field("dim")
    first = next((row for row in dimensions if len(row)), None)
    label = first[0]["label"].as_py() if first is not None else ""
    return [str(part) for part in label.split(",")] if label.strip(",") else []


def _numbers(array: pa.Array, where: str) -> Array:
    kind = array.type
    if pa.types.is_struct(kind):
        raise DataError(f"{where} is a group; add one of its fields: {', '.join(field.name for field in kind)}.")
    if pa.types.is_list(kind):
        counts = np.diff(array.offsets.to_numpy())
        if len(counts) == 0 or (counts != counts[0]).any() or counts[0] == 0:
            raise DataError(f"{where} is a list whose length changes; take one entry, e.g. [0] or [joint name].")
        return _numbers(array.flatten(), where).reshape(len(array), counts[0])
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)):
        raise DataError(f"{where} holds {kind}, not numbers.")
    return array.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)  # stamps have more digits than a float64
