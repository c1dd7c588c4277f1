"""What an evaluation found, for a person."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from dr_lab.reports.evaluate import Cell, EvaluateReport
from dr_lab.reports.page import Page, Section
from dr_lab.reports.quantity import titled, written
from dr_lab.reports.tables import table

_FIRST = 4  # figures that the first sentence tells
_RETURN = "return"  # column by which some rows are worse than others
_SHOWN = 40  # rows of the table in the page; all are in a file


def evaluate_page(
    report: EvaluateReport, told: str, rows: Sequence[Mapping[str, Cell]], file: str = "returns.csv"
) -> Page:
    """The figures and the table behind them.

    Args:
        report: what was found.
        told: what was played and what the figures mean.
        rows: of the table, with the same keys.
        file: that holds them all.
    """
    figures = [[name.replace("_", " "), written(value)] for name, value in report.figures.items()]
    header = [_column(name, report.units) for name in (rows[0] if rows else ())]
    shown, left_out = _most_important(rows, file)
    cells = [[written(value) for value in row.values()] for row in shown]
    sections = [
        Section("figures", "Figures", table(["figure", "value"], figures)),
        Section("rows", "Table", "\n\n".join(filter(None, (table(header, cells), left_out)))),
    ]
    first = _in_short(_with_intervals(figures)[:_FIRST])
    lead = f"**{first[:1].upper()}{first[1:]}.** {told}" if first else told
    return Page(f"{_spelt(report.evaluator)} of {Path(report.trained).name} on {report.env}", lead, sections)


def _most_important(rows: Sequence[Mapping[str, Cell]], file: str) -> tuple[Sequence[Mapping[str, Cell]], str]:
    """The rows that a page has room for, and a sentence on the others: the worst, where they have a return."""
    if len(rows) <= _SHOWN:
        return rows, ""
    if any(_RETURN not in row for row in rows):
        return rows[:_SHOWN], f"… and {len(rows) - _SHOWN} more in {file}."
    worst = sorted(rows, key=lambda row: _known(row[_RETURN]))[:_SHOWN]
    return worst, f"The {_SHOWN} worst of {len(rows)}, worst return first; {file} has all."


def _known(value: Cell) -> float:
    """A return to sort by; one that is unknown, as of a context that always diverges, is the worst of all."""
    return float(value) if value is not None and math.isfinite(float(value)) else -math.inf


def _spelt(evaluator: str) -> str:
    """The name of an evaluator's class, such as ``RealVsSimEvaluator``, in words."""
    return re.sub(r"(?<!^)([A-Z])", r" \1", evaluator.removesuffix("Evaluator")).capitalize()


def _with_intervals(figures: Sequence[Sequence[str]]) -> list[Sequence[str]]:
    """A figure that has a lower and an upper end as one: its value, then its interval.

    The ends of ``real`` are ``real.low`` and ``real.high``; ``a.low`` where no figure is called ``a`` is the lower end
    of the one before it, such as ``a.iqm``.
    """
    value = {name: each for name, each in figures}  # noqa: C416 (pairs of any sequence)
    told: dict[str, str] = {}
    for name, each in value.items():
        begin, _, end = name.rpartition(".")
        if end not in ("low", "high"):
            told[name] = each
            continue
        whose = begin if begin in value else next(reversed(told), "")
        low, high = (f"{begin}.{side}" if begin else side for side in ("low", "high"))
        if end == "high" and whose and low in value:
            told[whose] = f"{value[whose]} ({value[low]} … {value[high]})"
    return list(told.items())


def _in_short(figures: Sequence[Sequence[str]]) -> str:
    """Figures and their values in a row; what the names of all begin with, as ``uniform.``, is said once."""
    begins = {name.partition(".")[0] if "." in name else "" for name, _ in figures}
    common = begins.pop() if len(begins) == 1 else ""
    told = ", ".join(f"{_named(name.removeprefix(f'{common}.'))} {value}" for name, value in figures)
    return f"{common}: {told}" if common else told


def _named(figure: str) -> str:
    """Its name, apart from the value where it ends in a number."""
    return f"{figure}:" if figure[-1:].isdigit() else figure


def _column(name: str, units: Mapping[str, str]) -> str:
    """Its title; a parameter's name, which has a unit, stays as it is written in overrides."""
    return titled(name, units[name]) if name in units else name.replace("_", " ")
