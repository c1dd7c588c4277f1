"""A report in its file: written as JSON, read back into the dataclass that it was written from."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from dr_lab.files import write_text
from dr_lab.reports.plain import from_plain, to_plain
from dr_lab.reports.schema import validate

T = TypeVar("T")


def write_json(path: Path, report: object) -> None:
    """Write a report atomically; numbers that are not finite become null.

    Args:
        path: the file.
        report: a dataclass.

    Raises:
        DataError: a value cannot be stored as JSON; the message names its place.
        DrLabError: the folder cannot be written to.
    """
    text = json.dumps(to_plain(report), allow_nan=False, ensure_ascii=False, indent=2)
    write_text(path, text + "\n")


def typed(kind: type[T], content: Mapping[str, Any], path: Path) -> T:
    """The report that a file holds; keys that are not known are left aside.

    Args:
        kind: the dataclass.
        content: of the file.
        path: the file, for the message.

    Raises:
        DataError: a key is missing or of another type; the message names the file and every such place.
    """
    validate(content, str(path))
    return from_plain(kind, content)
