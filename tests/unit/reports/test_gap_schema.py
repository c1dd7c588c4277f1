"""`gap.schema.json` and the dataclasses say the same: which keys there are, of which type, and which must be there."""

import dataclasses
import json
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from dr_lab.reports import gap
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import IN_PLACE, OMITTED

SCHEMA = json.loads(Path(gap.__file__).with_name("gap.schema.json").read_text("utf-8"))
JSON = {str: "string", bool: "boolean", int: "integer", float: "number"}


def keys(kind: object) -> Iterator[tuple[str, Any, bool]]:
    """Each key of a dataclass in JSON, its type, and whether it must be there."""
    hints = typing.get_type_hints(kind)  # pyright: ignore[reportArgumentType]
    for field in dataclasses.fields(kind):  # pyright: ignore[reportArgumentType]
        if field.metadata == IN_PLACE:
            yield from ((name, hint, False) for name, hint, _ in keys(optional(hints[field.name])[0]))
        else:
            given = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
            hint = optional(hints[field.name])[0] if field.metadata == OMITTED else hints[field.name]
            yield field.name, hint, given


def optional(hint: object) -> tuple[Any, bool]:
    """A type without None, and whether None was among it."""
    if typing.get_origin(hint) not in (types.UnionType, typing.Union):
        return hint, False
    (inner,) = (each for each in typing.get_args(hint) if each is not type(None))
    return inner, True


def resolved(node: Mapping[str, Any]) -> Mapping[str, Any]:
    """A node of the schema, or the definition that it names."""
    return SCHEMA["$defs"][node["$ref"].rpartition("/")[2]] if "$ref" in node else node


def differences(hint: object, node: Mapping[str, Any], place: str) -> Iterator[str]:
    """Where a type and a node of the schema differ."""
    (hint, none), node = optional(hint), resolved(node)
    kinds = node.get("type", [])
    kinds = {kinds} if isinstance(kinds, str) else {*kinds}
    if "enum" in node or "const" in node:
        kinds = {"null" if value is None else "string" for value in node.get("enum", [node.get("const")])}
    arguments, origin = typing.get_args(hint), typing.get_origin(hint)
    kind = {tuple: "array", Mapping: "object"}.get(origin) or JSON.get(hint, "object")
    if kinds - {"null"} != {kind} or (none and "null" not in kinds):
        yield f"{place}: {kind}{' or null' if none else ''} is {sorted(kinds)} in the schema"
    if origin is tuple:
        yield from differences(arguments[0], node["items"], f"{place}[]")
    elif origin is Mapping:
        yield from differences(arguments[1], node["additionalProperties"], f"{place}.*")
    elif dataclasses.is_dataclass(hint):
        ours, theirs = {name: (inner, given) for name, inner, given in keys(hint)}, node.get("properties", {})
        yield from (f"{place}.{name} is in one of them alone" for name in ours.keys() ^ theirs.keys())
        required = {name for name, (_, given) in ours.items() if given}
        yield from (
            f"{place}.{name} is required in one of them alone" for name in required ^ {*node.get("required", ())}
        )
        for name in ours.keys() & theirs.keys():
            yield from differences(ours[name][0], theirs[name], f"{place}.{name}")


def test_schema_and_dataclasses_say_the_same() -> None:
    assert sorted(differences(GapReport, SCHEMA, "$")) == []


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"model": {"type": "integer"}}, "$.model: string is ['integer'] in the schema"),
        ({"colour": {"type": "string"}}, "$.colour is in one of them alone"),
    ],
)
def test_a_difference_is_found(changed: dict[str, Any], said: str) -> None:
    other = SCHEMA | {"properties": SCHEMA["properties"] | changed}
    assert list(differences(GapReport, other, "$")) == [said]
