"""Each schema and its dataclasses say the same: which keys there are, of which type, and which must be there."""

import dataclasses
import json
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from dr_lab.reports import gap
from dr_lab.reports.benchmark import BenchmarkReport
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import IN_PLACE, OMITTED, key_of
from dr_lab.reports.policy import PolicyReport
from dr_lab.reports.summarize import SummarizeReport
from dr_lab.reports.train import TrainReport

FOLDER = Path(gap.__file__).parent
REPORTS = {
    "gap": GapReport,
    "train": TrainReport,
    "evaluate": EvaluateReport,
    "benchmark": BenchmarkReport,
    "summarize": SummarizeReport,
    "policy": PolicyReport,
}
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
            yield key_of(field), hint, given


def optional(hint: object) -> tuple[Any, bool]:
    """A type without None, and whether None was among it."""
    if typing.get_origin(hint) not in (types.UnionType, typing.Union):
        return hint, False
    inner = [each for each in typing.get_args(hint) if each is not type(None)]
    return inner[0] if len(inner) == 1 else hint, len(inner) < len(typing.get_args(hint))


def kinds_of(hint: object) -> set[str]:
    """What a type is in JSON, None left out."""
    if typing.get_origin(hint) is types.UnionType:
        return {JSON[each] for each in typing.get_args(hint) if each in JSON}
    return {{tuple: "array", Mapping: "object"}.get(typing.get_origin(hint)) or JSON.get(hint, "object")}


def read(name: str) -> dict[str, Any]:
    return json.loads((FOLDER / f"{name}.schema.json").read_text("utf-8"))


def differences(hint: object, node: Mapping[str, Any], place: str, defs: Mapping[str, Any]) -> Iterator[str]:
    """Where a type and a node of the schema, or the definition that it names, differ."""
    (hint, none), node = optional(hint), defs[node["$ref"].rpartition("/")[2]] if "$ref" in node else node
    kinds = node.get("type", [])
    kinds = {kinds} if isinstance(kinds, str) else {*kinds}
    if "enum" in node or "const" in node:
        kinds = {"null" if value is None else "string" for value in node.get("enum", [node.get("const")])}
    arguments, origin = typing.get_args(hint), typing.get_origin(hint)
    ours = kinds_of(hint)
    if kinds - {"null"} != ours or (none and "null" not in kinds):
        yield f"{place}: {' or '.join(sorted(ours))}{' or null' if none else ''} is {sorted(kinds)} in the schema"
    if origin is tuple:
        yield from differences(arguments[0], node["items"], f"{place}[]", defs)
    elif origin is Mapping:
        yield from differences(arguments[1], node["additionalProperties"], f"{place}.*", defs)
    elif dataclasses.is_dataclass(hint):
        keyed, theirs = {name: (inner, given) for name, inner, given in keys(hint)}, node.get("properties", {})
        yield from (f"{place}.{name} is in one of them alone" for name in keyed.keys() ^ theirs.keys())
        required = {name for name, (_, given) in keyed.items() if given}
        yield from (
            f"{place}.{name} is required in one of them alone" for name in required ^ {*node.get("required", ())}
        )
        for name in keyed.keys() & theirs.keys():
            yield from differences(keyed[name][0], theirs[name], f"{place}.{name}", defs)


@pytest.mark.parametrize("name", REPORTS)
def test_schema_and_dataclasses_say_the_same(name: str) -> None:
    schema = read(name)
    assert sorted(differences(REPORTS[name], schema, "$", schema.get("$defs", {}))) == []


def test_every_schema_has_its_dataclass() -> None:
    assert {path.name for path in FOLDER.glob("*.schema.json")} == {f"{name}.schema.json" for name in REPORTS}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"model": {"type": "integer"}}, "$.model: string is ['integer'] in the schema"),
        ({"colour": {"type": "string"}}, "$.colour is in one of them alone"),
    ],
)
def test_a_difference_is_found(changed: dict[str, Any], said: str) -> None:
    schema = read("gap")
    other = schema | {"properties": schema["properties"] | changed}
    assert list(differences(GapReport, other, "$", schema["$defs"])) == [said]
