"""`report.md` of an evaluation, for a person."""

from pathlib import Path

from dr_lab.reports.evaluate import Cell, EvaluateReport
from dr_lab.reports.quantity import number, titled
from dr_lab.reports.tables import table

_SHOWN = 40  # rows of the table in the page; all are in returns.csv


def evaluate_markdown(report: EvaluateReport, told: str) -> str:
    """The figures and the table behind them.

    Args:
        report: what was found.
        told: what was played and what the figures mean.
    """
    rows = report.rows
    figures = [[name.replace("_", " "), number(value)] for name, value in report.figures.items()]
    header = [titled(name, report.units.get(name, "")) for name in (rows[0] if rows else ())]
    cells = [[_cell(value) for value in row.values()] for row in rows[:_SHOWN]]
    more = f"\n\n… and {len(rows) - _SHOWN} more in returns.csv." if len(rows) > _SHOWN else ""
    title = f"# What {Path(report.trained).name} on {report.env} returns"
    return f"{title}\n\n{told}\n\n{table(['figure', 'value'], figures)}\n\n{table(header, cells)}{more}\n"


def _cell(value: Cell) -> str:
    return value if isinstance(value, str) else number(value)
