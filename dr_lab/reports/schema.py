"""The stable form of `report.json`: `gap.schema.json`, for us and for other people's tools."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jsonschema import Draft202012Validator

from dr_lab.errors import DataError

_SCHEMA = json.loads(Path(__file__).with_name("gap.schema.json").read_text("utf-8"))


def validate(report: Mapping[str, Any]) -> None:
    """Check a report of compare, fit, diagnose, add or close against the schema.

    Args:
        report: as read back from `report.json`.

    Raises:
        DataError: keys are missing or of another type; the message lists every place.
    """
    problems = [f"{error.json_path}: {error.message}" for error in Draft202012Validator(_SCHEMA).iter_errors(report)]
    if problems:
        listed = "\n  ".join(sorted(problems))
        raise DataError(f"The report does not follow the schema {report.get('schema')!r}:\n  {listed}")
