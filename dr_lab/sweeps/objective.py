"""What a job reached: figures of the report that its workflow wrote."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.reports.places import beside, places

REPORT_FILE = "report.json"


def objectives(folder: Path, keys: Sequence[str]) -> tuple[float, ...]:
    """Figures of a run.

    Args:
        folder: of the run.
        keys: where they stand in ``report.json``, e.g. ``final_return`` or ``ladder.-1.held_out.chi2``, as `places`
            takes them.

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
    found = places(report, key)
    if key not in found:
        raise UnknownNameError("figure", key, beside(report, key), str(path))
    value = found[key]
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{key} in {path} is {value!r}; an objective must be a number.")
    return float(value)
