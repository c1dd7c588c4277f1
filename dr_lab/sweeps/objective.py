"""What a job reached: figures of the report that its workflow wrote."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from dr_lab.errors import DataError, UnknownNameError

REPORT_FILE = "report.json"


def objectives(folder: Path, keys: Sequence[str]) -> tuple[float, ...]:
    """Figures of a run.

    Args:
        folder: of the run.
        keys: where they stand in ``report.json``, e.g. ``final_return`` or ``ladder.-1.held_out.chi2``; the entries of
            a list have numbers, from the end negative ones.

    Returns:
        Each figure; NaN where the report has ``null``, e.g. because no episode ended.

    Raises:
        DataError: the run has no report, or something else than a number stands there.
        UnknownNameError: the report has no such key.
    """
    path = folder / REPORT_FILE
    if not path.is_file():
        raise DataError(f"{folder} holds no {REPORT_FILE}, so its objective {', '.join(keys)} is not known.")
    report = json.loads(path.read_text(encoding="utf-8"))
    return tuple(_figure(report, key, path) for key in keys)


def _figure(report: object, key: str, path: Path) -> float:
    value = report
    for part in key.split("."):
        children = _children(value)
        if part not in children:
            raise UnknownNameError("figure", key, children, str(path))
        value = children[part]
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{key} in {path} is {value!r}; an objective must be a number.")
    return float(value)


def _children(value: object) -> Mapping[str, object]:
    if isinstance(value, Mapping):
        return {str(key): child for key, child in value.items()}
    if isinstance(value, list):
        return {str(at): value[at] for at in range(-len(value), len(value))}
    return {}
