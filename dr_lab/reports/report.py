"""The files of a gap report: `report.json` for programs, `report.md` for people, `metrics.csv` for spreadsheets."""

from pathlib import Path

from dr_lab.files import write_text
from dr_lab.reports.gap import GapReport
from dr_lab.reports.json_file import write_json
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
