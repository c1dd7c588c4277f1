"""What a comparing verb found, for a person: `report.md`, and the text shown inside the recording."""

from collections.abc import Sequence

from dr_lab.reports.calibration import given_values
from dr_lab.reports.force_entries import MissingForceEntry, TermEntry
from dr_lab.reports.gap import Failure, GapReport
from dr_lab.reports.gap_entries import TRADE, NoteEntry, Parameters, RegionEntry
from dr_lab.reports.inertia import inertia_told
from dr_lab.reports.ladder import failing, scored
from dr_lab.reports.next_experiment import next_experiment_text
from dr_lab.reports.page import Page, Section
from dr_lab.reports.quantity import number, percent
from dr_lab.reports.rankings import rankings
from dr_lab.reports.tables import (
    channel_table,
    clock_table,
    horizon_table,
    ladder_table,
    noise_included,
    noise_table,
    parameter_table,
    per_log_table,
    ranking_table,
)
from dr_lab.reports.typed import add_formula_command, view_command
from dr_lab.reports.verdict import verdict_markdown

_MOSTLY = 0.5  # share of the variance


def report_markdown(report: GapReport) -> str:
    """Render a report of compare, fit, diagnose, add or close; see `gap_page`."""
    return gap_page(report).markdown()


def gap_page(report: GapReport) -> Page:
    """What a report of compare, fit, diagnose, add or close says to a person.

    Args:
        report: what was found; sections of which it says nothing are empty.
    """
    title = " · ".join(dict.fromkeys(name for name in (report.model, report.measurements, report.verb) if name))
    parameters, judgement, failure = report.catalogued[-1].parameters, report.judged, report.failing
    values = parameter_table(parameters, given_values(report))
    fitted = "\n\n".join(part for part in (values, _trades(report, parameters)) if part)
    sections = [
        Section("ladder", "Ladder of models", ladder_table(report)),
        Section("reasons", "Reasons", _reasons(report)),
        Section("channels", f"Error by channel, on {scored(report)}", channel_table(report)),
        Section("candidates", "Candidates", _candidates(report)),
        Section("parameters", "Parameters", fitted),
        Section("parameters_by_log", "Parameters by log", per_log_table(parameters)),
        Section("inertia", "What the logs know of the inertia", inertia_told(report.inertia)),
        Section("where", f"Where the {failing(report)} fails", _where(failure.where)),
        Section("missing_forces", "Missing forces", _missing_forces(report)),
        Section("horizons", f"Error of the {failing(report)} and horizon", horizon_table(report)),
        Section("correlations", f"Residual of the {failing(report)} and command", _correlations(failure)),
        Section("next_experiment", "Next experiment", next_experiment_text(judgement.next_experiment)),
        Section("noise", "Noise floor", noise_table(report.noise)),
        Section("notes", "Notes", notes_list([note for note in report.notes if note.kind != TRADE])),
        Section("clocks", "Clocks", clock_table(report.clocks)),
        Section("recording", "How to look at it", _how_to_look(report)),
    ]
    return Page(title, verdict_markdown(report), sections)


def _reasons(report: GapReport) -> str:
    """Why each rung's verdict is what it is."""
    told = [f"- {each.title}. {each.reason}" for each in rankings(report) if each.reason]
    return "\n".join(told)


def _candidates(report: GapReport) -> str:
    """A table of each rung; the rung is named where there are several."""
    found = [each for each in rankings(report) if each.rows]
    tables = [ranking_table(each.rows, report.verdict, report.judged.confidence) for each in found]
    if len(found) > 1:
        tables = [f"### {each.title}\n\n{table}" for each, table in zip(found, tables, strict=True)]
    return "\n\n".join(part for part in (noise_included(report) if found else "", *tables) if part)


def _where(regions: Sequence[RegionEntry]) -> str:
    lines = [f"- `{row.signal}`, {row.region}: {percent(row.share)} of its squared error" for row in regions]
    return "\n".join(lines)


def _trades(report: GapReport, parameters: Parameters) -> str:
    """Which parameters trade against each other, which take an effect's place, and which intervals are doubtful."""
    worst = report.judged.worst_direction
    lines = [f"- {note.message}" for note in report.notes if note.kind == TRADE]
    if len(worst) > 1:
        told = " ".join(f"{'+' if value > 0 else '−'} {abs(value):.2f} `{name}`" for name, value in worst.items())
        lines.append(f"- The logs know least of {told.removeprefix('+ ')} (in widths of the bounds): these trade.")
    for row in report.judged.ranking:
        if row.replaced_by:
            takers = ", ".join(f"`{name}`" for name in row.replaced_by)
            take = "takes" if len(row.replaced_by) == 1 else "take"
            lines.append(f"- `{row.label}` cannot be told from {takers}, which {take} its place.")
    return "\n".join([*lines, *beside_learned(report), *doubtful_intervals(parameters), *_by_step(parameters)])


def beside_learned(report: GapReport) -> list[str]:
    """A line that parameters have other values beside a learned force, which makes up for a part of what they do."""
    last = report.ladder[-1]
    if not last.learned:
        return []
    return [f"- Beside `{last.effects[-1]}`, as model=from_run has it, they have other values, those of report.json."]


def doubtful_intervals(parameters: Parameters) -> list[str]:
    """A line for each reason not to trust the intervals of some parameters."""
    doubted: dict[str, list[str]] = {}
    for name, row in parameters.items():
        for doubt in () if row.scatter is None else row.scatter.doubts:
            doubted.setdefault(doubt, []).append(f"`{name}`")
    return [f"- Do not trust the intervals of {', '.join(names)}: {doubt}." for doubt, names in doubted.items()]


def _by_step(parameters: Parameters) -> list[str]:
    """A line on the values whose uncertainty is the time step's more than anything else's."""
    told = {name: row.scatter.std_by_step for name, row in parameters.items() if row.scatter}
    mostly = [
        f"`{k}`" for k, by_step in told.items() if by_step and by_step**2 > _MOSTLY * (parameters[k].std or 0) ** 2
    ]
    if not mostly:
        return []
    told = f"- The time step that was simulated with gives most of the ± of {', '.join(mostly)}"
    return [f"{told}: a smaller `timestep` in the MJCF narrows it."]


def _missing_forces(report: GapReport) -> str:
    """How much of the missing force the effects took away and how much they could have, and a formula of the rest."""
    lines = []
    for row in report.judged.missing_force:
        could = "" if row.ceiling is None else f" (a regression on the measured state: {percent(row.ceiling)})"
        sizes = " → ".join(number(size, 3) for size in (row.rms_first, row.rms_last))
        beyond = f"{row.unit} RMS beyond the noise's {number(row.noise, 3)}"
        share = "none of it" if row.explained is not None and row.explained < 0 else percent(row.explained)
        explained = f"{share} explained{could}{_of_windows(row)}"
        lines.append(f"- `{row.joint}`: {sizes} {beyond}, {explained}.")
        left = row.left
        if left and left.terms:
            terms = " ".join(_term(term, first=k == 0) for k, term in enumerate(left.terms))
            lines[-1] += f" {percent(left.share)} of the rest follows F ≈ {terms} [{row.unit}]."
            if report.run and all(term.expression for term in left.terms):
                command = add_formula_command(report.run, row.joint, report.measurements)
                lines[-1] += f" Add it to the model and refine it: `{command}`."
    return "\n".join(lines)


def _of_windows(row: MissingForceEntry) -> str:
    return f", from {row.windows} short windows" if row.windows else ""


def _term(term: TermEntry, *, first: bool) -> str:
    value = term.coefficient or 0.0
    sign = ("−" if value < 0 else "") if first else ("− " if value < 0 else "+ ")
    name = "" if term.term == "1" else f" {term.term}"
    return f"{sign}{number(abs(value), 3)}{name}"


def _correlations(failure: Failure) -> str:
    """Residuals that still follow a command, beyond the 99 % band of chance."""
    lines = [
        f"- The residual of `{row.signal}` follows `{row.command}` after {_milliseconds(row.peak_lag)} ms: "
        f"correlation {number(row.peak, 2)}, chance stays below {number(row.band, 2)}"
        for row in failure.input_correlation
        if row.significant
    ]
    return "\n".join(lines)


def _milliseconds(seconds: float | None) -> str:
    return number(None if seconds is None else 1e3 * seconds, 3)


def notes_list(notes: Sequence[NoteEntry]) -> str:
    """What the data contract found and did, one line a note."""

    def place(note: NoteEntry) -> str:
        return " ".join(f"`{name}`" for name in (note.log, note.signal) if name)

    def said(note: NoteEntry) -> str:
        return note.message.removeprefix(f"{note.signal}: ")

    return "\n".join(f"- {place(note)}{': ' if place(note) else ''}{said(note)}" for note in notes)


def _how_to_look(report: GapReport) -> str:
    return f"`{view_command(report.run)}` opens the recording `review.rrd` beside this page."
