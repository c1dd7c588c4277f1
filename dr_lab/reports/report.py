"""The files of a gap report: `report.json` for programs, `report.md` for people, `metrics.csv` for spreadsheets."""

import json
from pathlib import Path

from dr_lab.errors import ConfigError, DataError
from dr_lab.files import write_text
from dr_lab.reports.gap import SCHEMA, GapReport
from dr_lab.reports.json_file import typed, write_json
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.metrics import metrics_csv


def write_report(folder: Path, report: GapReport) -> None:
    """Write `report.json`, `report.md` and `metrics.csv` into `folder`, each atomically.

    Args:
        folder: the run folder.
        report: what was found, numbers that are not finite being None (`dr_lab.reports.plain.finite`).

    Raises:
        DataError: a value cannot be stored as JSON; the message names its place.
        DrLabError: the folder cannot be written to.
    """
    write_json(folder / "report.json", report)
    write_text(folder / "report.md", report_markdown(report))
    write_text(folder / "metrics.csv", metrics_csv(report))


def read_gap(folder: Path, key: str) -> GapReport:
    """What `write_report` wrote into a run folder.

    Args:
        folder: the run folder.
        key: by which a user has given it, for messages.

    Raises:
        ConfigError: it holds no report, or that of a verb that compares nothing.
        DataError: the report cannot be read, or lacks what this version writes.
    """
    path, remedy = folder / "report.json", "Give the folder of a run of dr-lab close, diagnose or add."
    if not path.is_file():
        raise ConfigError(f"{key}={folder} holds no report.json. {remedy}")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"{path} cannot be read: {error}. Copy the whole run folder anew, or run it again.") from error
    found = content.get("schema") if isinstance(content, dict) else None
    if found != SCHEMA:
        raise ConfigError(
            f"{key}={folder} holds a report of schema {found!r}; expected {SCHEMA!r}, that of a comparison. {remedy}"
        )
    try:
        return typed(GapReport, content, path)
    except DataError as error:
        raise DataError(f"{error}\nRun it again, with this version of dr_lab.") from error
