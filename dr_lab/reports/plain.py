"""Between dataclasses and what JSON can hold.

A field of a dataclass is a key of a JSON object, with three exceptions that its metadata state: `OMITTED`, `IN_PLACE`
and `RETURN`.
"""

import dataclasses
import math
import types
import typing
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from dr_lab.errors import DataError

T = TypeVar("T")
OMITTED = {"key": "omitted"}  # metadata of a field that is no key where it is None
IN_PLACE = {"key": "in place"}  # metadata of a field whose fields are keys in its place; no keys where it is None
RETURN = {"key": "return"}  # metadata of a field whose key is Python's keyword

Number = float | None
"""A number of a report; None where there is no finite value."""


def to_plain(value: object, place: str = "report") -> object:
    """Turn `value` into what JSON can hold: dict, list, str, int, float, bool, None; NaN and infinity become None.

    Raises:
        DataError: a value of another type; the message names its place, e.g. ``report.ladder[0].chi2``.
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = _keys(value)
    if isinstance(value, Mapping):
        return {str(key): to_plain(item, f"{place}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [to_plain(item, f"{place}[{index}]") for index, item in enumerate(value)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    if value is None or isinstance(value, str | bool | int):
        return value
    raise DataError(f"{place} is a {type(value).__name__}; a report holds numbers, strings, lists and mappings only.")


def from_plain(kind: type[T], data: Mapping[str, Any]) -> T:
    """The dataclass that JSON was written from; keys that it does not know are left aside.

    Args:
        kind: the dataclass.
        data: the JSON object.

    Raises:
        TypeError: a key without a default is missing.
    """
    hints, found = typing.get_type_hints(kind), {}
    for field in dataclasses.fields(kind):  # pyright: ignore[reportArgumentType]
        hint = _without_none(hints[field.name])
        if field.metadata == IN_PLACE:
            own = {key_of(f): data[key_of(f)] for f in dataclasses.fields(hint) if key_of(f) in data}
            found[field.name] = from_plain(hint, own) if own else None
        elif key_of(field) in data:
            found[field.name] = _typed(hint, data[key_of(field)])
    return kind(**found)


def finite(report: T) -> T:
    """The same dataclass as it is written and read back: tuples for arrays, None for what is not finite."""
    return from_plain(type(report), typing.cast(dict[str, Any], to_plain(report)))


def key_of(field: "dataclasses.Field[Any]") -> str:
    """The key of a field that is one."""
    return "return" if field.metadata == RETURN else field.name


def _keys(value: Any) -> dict[str, object]:  # noqa: ANN401 (any dataclass)
    found: dict[str, object] = {}
    for field in dataclasses.fields(value):
        content = getattr(value, field.name)
        if field.metadata == IN_PLACE:
            found |= {} if content is None else _keys(content)
        elif content is not None or field.metadata != OMITTED:
            found[key_of(field)] = content
    return found


def _typed(hint: Any, value: Any) -> Any:  # noqa: ANN401 (types and values of fields)
    if value is None:
        return None
    hint = _without_none(hint)
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if dataclasses.is_dataclass(hint):
        return from_plain(typing.cast(type, hint), value)
    if origin in (tuple, Sequence):
        return tuple(_typed(arguments[0], item) for item in value)
    if origin is Mapping:
        return {key: _typed(arguments[1], item) for key, item in value.items()}
    return value


def _without_none(hint: Any) -> Any:  # noqa: ANN401 (a type)
    """``X`` of ``X | None``; a union of several others, which are numbers and words, as it is."""
    if typing.get_origin(hint) not in (types.UnionType, typing.Union):
        return hint
    others = [each for each in typing.get_args(hint) if each is not type(None)]
    return others[0] if len(others) == 1 else hint
