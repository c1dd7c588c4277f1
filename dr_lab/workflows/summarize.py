"""Verb `summarize`: one table and one recording of many runs."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markdown import Markdown

from dr_lab.recorders.files import write_text
from dr_lab.recorders.look import Look
from dr_lab.recorders.report import to_plain
from dr_lab.recorders.sweep_review import SweepRecord, write_sweep_review
from dr_lab.workflows.sweep_summary.doubts import divided_runs, missing_figures, repeated_runs, require_known
from dr_lab.workflows.sweep_summary.groups import (
    Cells,
    Estimate,
    Group,
    Statistics,
    grouped,
    shared_figures,
    summed_up,
)
from dr_lab.workflows.sweep_summary.overlays import bands, grids, marginals
from dr_lab.workflows.sweep_summary.runs import SUMMARY_SCHEMA, find_runs
from dr_lab.workflows.sweep_summary.tables import groups_csv, runs_csv, runs_page, summary_page


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
    folder = Path(sweep).expanduser()
    runs, unfinished = find_runs(folder)
    require_known(runs, aggregate)
    groups = grouped(runs, aggregate, ignored)
    repeated, divided = repeated_runs(runs, ignored), divided_runs(groups, [*ignored, *aggregate])
    notes = [*repeated, *divided, *missing_figures(runs, figures)]
    cells = [summed_up(group, figures, statistics) for group in groups]
    name = folder.resolve().name or str(folder)
    page = summary_page(
        name, groups, cells, shared_figures(groups, figures), [*_unfinished(unfinished), *notes], statistics
    )
    report = _report(folder, groups, cells) | {"unfinished": unfinished, "notes": notes, "run": str(run_dir)}
    write_text(run_dir / "runs.csv", runs_csv(runs, figures))
    write_text(run_dir / "groups.csv", groups_csv(groups, cells))
    write_text(run_dir / "report.json", json.dumps(report, ensure_ascii=False, indent=2) + "\n")
    write_text(run_dir / "report.md", page)
    pages = {"Summary": page, "Runs": runs_page(runs, figures)}
    write_sweep_review(run_dir / "review.rrd", _record(name, groups, statistics, pages), recorder)
    Console().print(Markdown(page))
    return report


def _record(name: str, groups: Sequence[Group], statistics: Statistics, pages: Mapping[str, str]) -> SweepRecord:
    labels = [group.label for group in groups]
    return SweepRecord(name, labels, bands(groups, statistics), marginals(groups), grids(groups), pages)


def _unfinished(names: Sequence[str]) -> list[str]:
    return [f"Without a report: {', '.join(names)}."] if names else []


def _report(folder: Path, groups: Sequence[Group], cells: Sequence[Cells]) -> dict[str, Any]:
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
        for group, row in zip(groups, cells, strict=True)
    ]
    plain = to_plain({"schema": SUMMARY_SCHEMA, "verb": "summarize", "sweep": folder, "groups": entries})
    assert isinstance(plain, dict)
    return plain
