"""Verb `summarize`: one table and one recording of many runs."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markdown import Markdown

from dr_lab.files import write_text
from dr_lab.recorders.look import Look
from dr_lab.recorders.sweep_review import SweepRecord, write_sweep_review
from dr_lab.reports.plain import to_plain
from dr_lab.summaries.doubts import divided_runs, missing_figures, repeated_runs, require_known
from dr_lab.summaries.exhaustive import exhaustive
from dr_lab.summaries.groups import (
    Cells,
    Estimate,
    Group,
    Statistics,
    grouped,
    shared_figures,
    summed_up,
)
from dr_lab.summaries.overlays import bands, grids, marginals
from dr_lab.summaries.runs import SUMMARY_SCHEMA, Run, find_runs
from dr_lab.summaries.tables import groups_csv, runs_csv, runs_page, summary_page


def summarize(
    sweep: str,
    aggregate: Sequence[str],
    ignored: Sequence[str],
    figures: Mapping[str, Sequence[str]],
    statistics: Statistics,
    recorder: Look,
    run_dir: Path,
) -> dict[str, Any]:
    """Compare the finished runs below a folder; those that differ in nothing but the seed are taken together.

    What was typed tells runs apart, and so does what they were configured with.

    Files: ``runs.csv`` (a row a run), ``groups.csv`` (a row a group), ``report.json``, ``report.md``, ``review.rrd``.

    Args:
        sweep: folder that holds the runs, at any depth.
        aggregate: overrides over which runs are taken together.
        ignored: keys of their configurations that say nothing about the experiment.
        figures: paths into a report that are compared, by its schema.
        statistics: how runs of a group are summed up.
        recorder: how the recording looks.
        run_dir: the run folder.

    Returns:
        The report (schema dr_lab/summarize/1).

    Raises:
        DataError: no run is finished, or one cannot be read.
        ConfigError: not one of the figures was found.
        UnknownNameError: no run has a key over which they are to be taken together.
    """
    found = _compared(Path(sweep).expanduser(), aggregate, ignored, figures, statistics)
    shared = shared_figures(found.groups, figures)
    page = summary_page(found.name, found.groups, found.cells, shared, found.told, statistics)
    report = _report(sweep, found) | {"run": str(run_dir)}
    _write(run_dir, found, figures, page, report)
    write_sweep_review(run_dir / "review.rrd", _record(found, figures, statistics, page), recorder)
    Console().print(Markdown(page))
    return report


@dataclass(frozen=True)
class _Compared:
    """Runs of a folder with what makes groups of them."""

    name: str
    runs: Sequence[Run]
    unfinished: Sequence[str]
    groups: Sequence[Group]
    cells: Sequence[Cells]
    notes: Sequence[str]

    @property
    def told(self) -> list[str]:
        """Sentences for the page."""
        lacking = [f"Without a report: {', '.join(self.unfinished)}."] if self.unfinished else []
        return [*lacking, *self.notes]


def _compared(
    folder: Path,
    aggregate: Sequence[str],
    ignored: Sequence[str],
    figures: Mapping[str, Sequence[str]],
    statistics: Statistics,
) -> _Compared:
    runs, unfinished = find_runs(folder)
    require_known(runs, aggregate)
    groups = grouped(runs, aggregate, ignored)
    repeated, divided = repeated_runs(runs, ignored), divided_runs(groups, [*ignored, *aggregate])
    notes = [*repeated, *divided, *missing_figures(runs, figures)]
    cells = [summed_up(group, figures, statistics) for group in groups]
    return _Compared(folder.resolve().name or str(folder), runs, unfinished, groups, cells, notes)


def _write(
    run_dir: Path, found: _Compared, figures: Mapping[str, Sequence[str]], page: str, report: Mapping[str, Any]
) -> None:
    write_text(run_dir / "runs.csv", runs_csv(found.runs, figures))
    write_text(run_dir / "groups.csv", groups_csv(found.groups, found.cells))
    write_text(run_dir / "report.json", json.dumps(report, ensure_ascii=False, indent=2) + "\n")
    write_text(run_dir / "report.md", page)


def _record(found: _Compared, figures: Mapping[str, Sequence[str]], statistics: Statistics, page: str) -> SweepRecord:
    groups, pages = found.groups, {"Summary": page, "Runs": runs_page(found.runs, figures)}
    apart = exhaustive(groups)
    labels = [*(group.label for group in groups), *apart]
    return SweepRecord(found.name, labels, bands(groups, statistics), marginals(groups), grids(groups) | apart, pages)


def _report(sweep: str, found: _Compared) -> dict[str, Any]:
    entries = [
        {
            "settings": dict(group.settings),
            "runs": [run.name for run in group.runs],
            "figures": {
                name: {"iqm": cell.value, "low": cell.low, "high": cell.high, "runs": cell.runs}
                if isinstance(cell, Estimate)
                else dict(cell)
                for name, cell in row.items()
            },
        }
        for group, row in zip(found.groups, found.cells, strict=True)
    ]
    plain = to_plain(
        {"schema": SUMMARY_SCHEMA, "verb": "summarize", "sweep": Path(sweep).expanduser(), "groups": entries}
    )
    assert isinstance(plain, dict)
    return plain | {"unfinished": found.unfinished, "notes": found.notes}
