"""The stable form of each report: `<its name>.schema.json`, for us and for other people's tools."""

import functools
import json
from collections.abc import Mapping
from pathlib import Path

from jsonschema import Draft202012Validator

from dr_lab.errors import DataError, UnknownNameError


def validate(report: object, place: str = "The report") -> None:
    """Check a report against the schema that it names.

    Args:
        report: as read back from its file.
        place: where it stands, for the message.

    Raises:
        DataError: it is no object, or keys are missing or of another type; the message lists every place.
        UnknownNameError: there is no such schema.
    """
    if not isinstance(report, Mapping):
        raise DataError(f"{place} holds a {type(report).__name__}; expected a JSON object, as dr-lab writes it.")
    name = str(report.get("schema"))
    schemas = _schemas()
    if name not in schemas:
        raise UnknownNameError("schema", name, schemas, place)
    problems = [f"{error.json_path}: {error.message}" for error in schemas[name].iter_errors(report)]
    if problems:
        listed = "\n  ".join(sorted(problems))
        raise DataError(f"{place} does not follow the schema {name!r}:\n  {listed}")


@functools.cache
def _schemas() -> Mapping[str, Draft202012Validator]:
    """The validator of each schema, by its name."""
    read = [json.loads(path.read_text("utf-8")) for path in Path(__file__).parent.glob("*.schema.json")]
    return {schema["properties"]["schema"]["const"]: Draft202012Validator(schema) for schema in read}
