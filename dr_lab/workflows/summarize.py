"""Verb `summarize`: one table and one recording of many runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console

from dr_lab.files import write_text
from dr_lab.html.sweep_page import write_sweep_page
from dr_lab.recorders.interference import Interference
from dr_lab.recorders.look import Look
from dr_lab.recorders.sweep_review import SweepRecord, write_sweep_review
from dr_lab.reports.json_file import write_json
from dr_lab.reports.plain import Number, finite
from dr_lab.reports.screen import ScreenMarkdown
from dr_lab.reports.summarize import SCHEMA, GroupEntry, SummarizeReport
from dr_lab.summaries.doubts import divided_runs, lost_trainings, missing_figures, repeated_runs, require_known
from dr_lab.summaries.evaluated import with_trained
from dr_lab.summaries.exhaustive import exhaustive
from dr_lab.summaries.groups import (
    Cell,
    Cells,
    Estimate,
    Group,
    find_group,
    grouped,
    shared_figures,
    summed_up,
    units_of,
)
from dr_lab.summaries.interference_tables import interference_entries, interference_section
from dr_lab.summaries.interferences import interferences
from dr_lab.summaries.overlays import bands, grids, marginals, violins
from dr_lab.summaries.runs import Run, find_runs
from dr_lab.summaries.sampling import Sampling, samplings
from dr_lab.summaries.sampling_tables import sampling_entries, sampling_section
from dr_lab.summaries.settings import SummarySettings
from dr_lab.summaries.tables import groups_csv, runs_csv, runs_page, summary_page


def summarize(sweep: str, settings: SummarySettings, recorder: Look, run_dir: Path) -> SummarizeReport:
    """Compare the finished runs below a folder; those that differ in nothing but the seed are taken together.

    What was typed tells runs apart, and so does what they were configured with.

    Files: ``runs.csv`` (a row a run), ``groups.csv`` (a row a group), ``report.json``, ``report.md``,
    ``report.html``, ``review.rrd``.

    Args:
        sweep: folder that holds the runs, at any depth.
        settings: which runs are taken together, and what of them is compared.
        recorder: how the recording looks.
        run_dir: the run folder.

    Raises:
        DataError: no run is finished, or one cannot be read.
        ConfigError: not one of the figures was found.
        UnknownNameError: no run has a key over which they are to be taken together, or no group is the reference.
    """
    folder, figures = Path(sweep).expanduser(), settings.figures
    found = _compared(folder, settings)
    shared = shared_figures(found.groups, figures)
    compared = found.groups, found.cells, shared, found.told, settings.statistics, found.reference, found.units
    page = summary_page(found.name, *compared)
    drawn = sampling_section(found.sampling, settings.sampling), interference_section(found.interference)
    page = replace(page, sections=[*page.sections[:1], *drawn, *page.sections[1:]])
    report = _report(folder, found, run_dir)
    write_text(run_dir / "runs.csv", runs_csv(found.runs, figures))
    write_text(run_dir / "groups.csv", groups_csv(found.groups, found.cells))
    write_json(run_dir / "report.json", report)
    text = page.markdown()
    write_text(run_dir / "report.md", text)
    record = _record(found, settings, text)
    write_sweep_page(run_dir / "report.html", page, report, record)
    write_sweep_review(run_dir / "review.rrd", record, recorder)
    Console().print(ScreenMarkdown(text))
    return report


@dataclass(frozen=True)
class _Compared:
    """Runs of a folder with what makes groups of them."""

    name: str
    runs: Sequence[Run]
    unfinished: Sequence[str]
    groups: Sequence[Group]
    cells: Sequence[Cells]
    reference: Group
    units: Mapping[str, str]
    notes: Sequence[str]
    sampling: Mapping[str, Sequence[Sampling]]
    interference: Sequence[Interference]

    @property
    def told(self) -> list[str]:
        """Sentences for the page."""
        lacking = [f"Without a report: {', '.join(self.unfinished)}."] if self.unfinished else []
        return [*lacking, *self.notes]


def _compared(folder: Path, settings: SummarySettings) -> _Compared:
    runs, unfinished = find_runs(folder)
    require_known(runs, settings.aggregate)
    aggregate, ignored, figures = with_trained(settings.aggregate), with_trained(settings.ignored), settings.figures
    groups = grouped(runs, aggregate, ignored)
    repeated, divided = repeated_runs(runs, ignored), divided_runs(groups, [*ignored, *aggregate])
    notes = [*lost_trainings(runs), *repeated, *divided, *missing_figures(runs, figures)]
    reference = find_group(groups, settings.reference)
    cells = [summed_up(group, figures, settings.statistics, reference) for group in groups]
    learning = samplings(groups, settings.sampling), interferences(groups, settings.statistics.confidence)
    name, units = folder.resolve().name or str(folder), units_of(groups, figures)
    return _Compared(name, runs, unfinished, groups, cells, reference, units, notes, *learning)


def _record(found: _Compared, settings: SummarySettings, page: str) -> SweepRecord:
    groups, pages = found.groups, {"Summary": page, "Runs": runs_page(found.runs, settings.figures, found.units)}
    apart = exhaustive(groups)
    labels, drawn = [*(group.label for group in groups), *apart], grids(groups) | apart
    learned = bands(groups, settings.statistics), marginals(groups)
    sampled = {name: [each.sampled for each in of_parameter] for name, of_parameter in found.sampling.items()}
    return SweepRecord(found.name, labels, *learned, drawn, violins(groups), pages, sampled, found.interference)


def _report(folder: Path, found: _Compared, run_dir: Path) -> SummarizeReport:
    entries = tuple(
        GroupEntry(group.settings, tuple(run.name for run in group.runs), {k: _figure(cell) for k, cell in row.items()})
        for group, row in zip(found.groups, found.cells, strict=True)
    )
    told = tuple(found.unfinished), tuple(found.notes)
    learning = sampling_entries(found.sampling), interference_entries(found.interference)
    return finite(
        SummarizeReport(SCHEMA, "summarize", str(folder), entries, *told, str(run_dir), *learning, found.units)
    )


def _figure(cell: Cell) -> dict[str, Number]:
    if not isinstance(cell, Estimate):
        return dict(cell)
    found: dict[str, Number] = {"iqm": cell.value, "low": cell.low, "high": cell.high, "runs": cell.runs}
    if cell.larger is not None:
        found |= {"larger": cell.larger.value, "larger_low": cell.larger.low, "larger_high": cell.larger.high}
    return found
