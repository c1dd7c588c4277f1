"""The runs below a folder, and what of their reports is compared."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from dr_lab.errors import DataError
from dr_lab.reports import evaluate, summarize, train
from dr_lab.reports.evaluate import EvaluateReport
from dr_lab.reports.json_file import typed
from dr_lab.reports.places import places
from dr_lab.reports.train import TrainReport
from dr_lab.summaries.evaluated import of_training
from dr_lab.sweeps.overrides import by_key
from dr_lab.trajectory import Array

_TYPES = {train.SCHEMA: TrainReport, evaluate.SCHEMA: EvaluateReport}
_REPORT, _CONFIG, _METRICS, _CONTEXTS = "report.json", "config.yaml", "metrics.csv", "contexts.csv"
_UNIT = "unit"
_RESUMED = "resume"  # override that says where a run was gone on with, which makes no other run of it
_UNREADABLE = "{} cannot be read as a run: {}. Take it out of {}."

Figure = float | str
"""A number, or a word such as a verdict."""


@dataclass(frozen=True)
class Run:
    """A finished run.

    Attributes:
        name: its folder, seen from the sweep's.
        folder: the same from here.
        overrides: what was typed for it, value by key, but for the run that it went on with; of an evaluation what was
            typed for the training stands in place of its folder, below ``trained``.
        configuration: its ``config.yaml``, likewise.
        report: its ``report.json``, from which figures are picked by their paths.
        content: the same of training or of an evaluation, typed; None of other verbs.
    """

    name: str
    folder: Path
    overrides: Mapping[str, str]
    configuration: Mapping[str, Any]
    report: Mapping[str, object]
    content: TrainReport | EvaluateReport | None


def find_runs(sweep: Path) -> tuple[list[Run], list[str]]:
    """Runs at any depth below a folder, in the order of their numbers.

    Args:
        sweep: the folder.

    Returns:
        The finished runs, and the names of those without a report; summaries, this one included, are no runs.

    Raises:
        DataError: there is no such folder, no finished run below it, or a file that cannot be read.
    """
    if not sweep.is_dir():
        raise DataError(f"There is no folder {sweep}. Give sweep=FOLDER, which a run with -m printed at its end.")
    found = (path.parent for path in sweep.rglob(_CONFIG) if not _is_of_summary(path))
    folders = sorted(found, key=lambda folder: _place(folder, sweep))
    finished = [folder for folder in folders if (folder / _REPORT).is_file()]
    runs = [_read(folder, sweep) for folder in finished]
    runs = [run for run in runs if run.report["schema"] != summarize.SCHEMA]
    if not runs:
        raise DataError(f"Below {sweep} no run is finished: no folder holds a {_CONFIG} and a {_REPORT}.")
    return runs, [str(folder.relative_to(sweep)) for folder in folders if folder not in finished]


def picked(report: Mapping[str, object], paths: Sequence[str]) -> dict[str, Figure]:
    """Numbers and words of a report.

    Args:
        report: what to pick from.
        paths: as `places` takes them.

    Returns:
        By their full path; a null is NaN, what is not there is left out.
    """
    found = {name: value for path in paths for name, value in places(report, path).items()}
    return {name: figure for name, value in found.items() for figure in _figures(value)}


def units(report: Mapping[str, object], paths: Sequence[str]) -> dict[str, str]:
    """Units that stand beside numbers of a report, by the full paths of these.

    Args: as `picked`.
    """
    ends = [path.rpartition(".") for path in paths]
    found = [(last, places(report, f"{above}.{_UNIT}")) for above, _, last in ends]
    return {name.removesuffix(_UNIT) + last: str(unit) for last, told in found for name, unit in told.items()}


def history(run: Run) -> dict[str, Array]:
    """Columns of a training run's ``metrics.csv``, NaN where empty; nothing where it was not trained.

    Raises:
        DataError: it cannot be read, or a value is no number.
    """
    return _columns(run, _METRICS)


def drawn_contexts(run: Run) -> dict[str, Array]:
    """Columns of a training run's ``contexts.csv``; nothing where it was not trained, or by an earlier version.

    Raises:
        DataError: it cannot be read, or a value is no number.
    """
    return _columns(run, _CONTEXTS)


def _columns(run: Run, name: str) -> dict[str, Array]:
    path = run.folder / name
    if not isinstance(run.content, TrainReport) or not path.is_file():
        return {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        return {name: np.array([float(row[name] or "nan") for row in rows]) for name in (rows[0] if rows else ())}
    except (ValueError, TypeError, csv.Error) as error:  # TypeError: a row has more values than there are columns
        raise DataError(f"{path}: {error}. Expected the {name} of a training run.") from None


def _figures(value: object) -> list[Figure]:
    """What lies at the end of a path, if it is a figure."""
    if value is None:
        return [math.nan]
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return []
    return [value if isinstance(value, str) else float(value)]


def _read(folder: Path, sweep: Path) -> Run:
    try:
        report = json.loads((folder / _REPORT).read_text(encoding="utf-8"))
        configuration = yaml.safe_load((folder / _CONFIG).read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise DataError(_UNREADABLE.format(folder, error, sweep)) from error
    if not isinstance(report, dict) or not isinstance(report.get("schema"), str):
        raise DataError(_UNREADABLE.format(folder, f"its {_REPORT} has no schema", sweep))
    made_with = configuration.get("made_with") if isinstance(configuration, dict) else None
    if not isinstance(made_with, dict) or not isinstance(made_with.get("overrides", []), list):
        raise DataError(_UNREADABLE.format(folder, f"its {_CONFIG} does not say what the run was made with", sweep))
    overrides = by_key([str(override) for override in made_with.get("overrides", [])])
    overrides.pop(_RESUMED, None)
    try:
        content = _content(report, folder / _REPORT)
    except DataError as error:
        raise DataError(f"{error}\nTake it out of {sweep}, or summarise it with the version that wrote it.") from None
    if isinstance(content, EvaluateReport):
        overrides, configuration = of_training(content.trained, overrides, configuration)
    return Run(str(folder.relative_to(sweep)), folder, overrides, configuration, report, content)


def _content(report: Mapping[str, object], path: Path) -> TrainReport | EvaluateReport | None:
    kind = _TYPES.get(str(report["schema"]))
    return None if kind is None else typed(kind, report, path)


def _is_of_summary(config: Path) -> bool:
    """Whether a configuration is that of a summary, one that was refused included: its first line is the command."""
    with config.open(encoding="utf-8", errors="replace") as file:
        return file.readline().startswith("# dr-lab summarize")


def _place(folder: Path, sweep: Path) -> list[tuple[bool, int, str]]:
    """Numbers by size and before names, level by level."""
    parts = folder.relative_to(sweep).parts
    return [(not part.isdigit(), int(part) if part.isdigit() else 0, part) for part in parts]
