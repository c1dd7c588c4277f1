"""`report.json`: what a run found, for programs; `schema.py` says what it holds."""

import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dr_lab.errors import DataError
from dr_lab.files import write_text
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.metrics import metrics_csv


def write_report(folder: Path, report: Mapping[str, Any]) -> None:
    """Write `report.json`, `report.md` and `metrics.csv` into `folder`, each atomically.

    Args:
        folder: the run folder.
        report: keys and units as in `gap.schema.json`; NumPy scalars and arrays, paths, tuples and dataclasses
            are converted, numbers that are not finite become null.

    Raises:
        DataError: a value cannot be stored as JSON; the message names its place.
        DrLabError: the folder cannot be written to.
    """
    text = json.dumps(to_plain(report), allow_nan=False, ensure_ascii=False, indent=2)
    write_text(folder / "report.json", text + "\n")
    plain = json.loads(text)
    write_text(folder / "report.md", report_markdown(plain))
    write_text(folder / "metrics.csv", metrics_csv(plain))


def to_plain(value: object, place: str = "report") -> object:
    """Turn `value` into what JSON can hold: dict, list, str, int, float, bool, None; NaN and infinity become None.

    Raises:
        DataError: a value of another type; the message names its place, e.g. ``report.ladder[0].chi2``.
    """
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
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
