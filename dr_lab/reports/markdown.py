"""`report.md`: what a run found, for a person; also the text shown inside the recording."""

from collections.abc import Sequence

from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import (
    CorrelationEntry,
    ExperimentEntry,
    MissingForceEntry,
    NoteEntry,
    Parameters,
    RegionEntry,
    TermEntry,
)
from dr_lab.reports.ladder import failing, judged, scored
from dr_lab.reports.quantity import number, percent
from dr_lab.reports.tables import (
    channel_table,
    clock_table,
    horizon_table,
    ladder_table,
    noise_table,
    parameter_table,
    per_log_table,
    ranking_table,
)
from dr_lab.reports.verdict import verdict_markdown
from dr_lab.reports.view_command import view_command


def report_markdown(report: GapReport) -> str:
    """Render a report of compare, fit, diagnose, add or close.

    Args:
        report: what was found; sections of which it says nothing are left out.

    Returns:
        Markdown with tables and without mathematics, so that every viewer shows it.
    """
    title = " · ".join(dict.fromkeys(name for name in (report.model, report.measurements, report.verb) if name))
    parameters, judgement, failure = report.ladder[-1].parameters, report.judged, report.failing
    sections = [
        f"# {title}",
        verdict_markdown(report),
        _section("Ladder of models", ladder_table(report)),
        _section("Reasons", _reasons(report)),
        _section(f"Error by channel, on {scored(report)}", channel_table(report)),
        _section("Candidates", ranking_table(judgement.ranking, report.verdict)),
        _section("Parameters", parameter_table(parameters)),
        _trades(report, parameters),
        _section("Parameters by log", per_log_table(parameters)),
        _section(f"Where the {failing(report)} fails", _where(failure.where)),
        _section("Missing forces", _missing_forces(judgement.missing_force)),
        _section(f"Error of the {failing(report)} and horizon", horizon_table(report)),
        _section(f"Residual of the {failing(report)} and command", _correlations(failure.input_correlation)),
        _section("Next experiment", _next_experiment(judgement.next_experiment)),
        _section("Noise floor", noise_table(report.noise)),
        _section("Notes", notes_list(report.notes)),
        _section("Clocks", clock_table(report.clocks)),
        _section("How to look at it", _how_to_look(report)),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def _reasons(report: GapReport) -> str:
    """Why each rung's verdict is what it is; the first rung's alone where there is but one."""
    alone = [(report.verdict, report.judged.reason)] if report.judged.reason else []
    told = [(rung.verdict, rung.reason) for rung in report.judged.rungs] or alone
    return "\n".join(f"- {judged(word or '', report.verdict)}: {reason}" for word, reason in told)


def _where(regions: Sequence[RegionEntry]) -> str:
    lines = [f"- `{row.signal}`, {row.region}: {percent(row.share)} of its squared error" for row in regions]
    return "\n".join(lines)


def _trades(report: GapReport, parameters: Parameters) -> str:
    """Which parameters trade against each other, which take an effect's place, and which intervals are doubtful."""
    worst = report.judged.worst_direction
    lines = []
    if len(worst) > 1:
        told = " ".join(f"{'+' if value > 0 else '−'} {abs(value):.2f} `{name}`" for name, value in worst.items())
        lines.append(f"- The logs know least of {told.removeprefix('+ ')} (in widths of the bounds): these trade.")
    for row in report.judged.ranking:
        if row.replaced_by:
            takers = ", ".join(f"`{name}`" for name in row.replaced_by)
            lines.append(f"- `{row.label}` cannot be told from {takers}, which take its place.")
    doubted: dict[str, list[str]] = {}
    for name, row in parameters.items():
        for doubt in () if row.scatter is None else row.scatter.doubts:
            doubted.setdefault(doubt, []).append(f"`{name}`")
    lines += [f"- Do not trust the intervals of {', '.join(names)}: {doubt}." for doubt, names in doubted.items()]
    return "\n".join(lines)


def _missing_forces(rows: Sequence[MissingForceEntry]) -> str:
    """How much of the missing force the effects took away and how much they could have, and a formula of the rest."""
    lines = []
    for row in rows:
        could = "" if row.ceiling is None else f" (a force of the measured state could: {percent(row.ceiling)})"
        sizes = " → ".join(number(size, 3) for size in (row.rms_first, row.rms_last))
        beyond = f"{row.unit} RMS beyond the noise's {number(row.noise, 3)}"
        explained = f"{percent(row.explained)} explained{could}{_of_windows(row)}"
        lines.append(f"- `{row.joint}`: {sizes} {beyond}, {explained}.")
        left = row.left
        if left and left.terms:
            terms = " ".join(_term(term, first=k == 0) for k, term in enumerate(left.terms))
            lines[-1] += f" {percent(left.share)} of the rest follows F ≈ {terms} [{row.unit}]."
    return "\n".join(lines)


def _of_windows(row: MissingForceEntry) -> str:
    return f", from {row.windows} short windows" if row.windows else ""


def _term(term: TermEntry, *, first: bool) -> str:
    value = term.coefficient or 0.0
    sign = ("−" if value < 0 else "") if first else ("− " if value < 0 else "+ ")
    name = "" if term.term == "1" else f" {term.term}"
    return f"{sign}{number(abs(value), 3)}{name}"


def _correlations(rows: Sequence[CorrelationEntry]) -> str:
    """Residuals that still follow a command, beyond the 99 % band of chance."""
    lines = [
        f"- The residual of `{row.signal}` follows `{row.command}` after {_milliseconds(row.peak_lag)} ms: "
        f"correlation {number(row.peak, 2)}, chance stays below {number(row.band, 2)}"
        for row in rows
        if row.significant
    ]
    return "\n".join(lines)


def _milliseconds(seconds: float | None) -> str:
    return number(None if seconds is None else 1e3 * seconds, 3)


def _next_experiment(proposal: ExperimentEntry | None) -> str:
    if proposal is None:
        return ""
    pair = " from ".join(f"`{effect}`" for effect in proposal.separates[:2])
    apart = f"{number(proposal.sigma, 2)} σ"
    if proposal.sigma is not None and proposal.sigma < proposal.needed:
        return (
            f"No command that was tried separates {pair}: `{proposal.command_file}` comes farthest, with {apart}. "
            "To these sensors they may be the same; a further channel would tell them apart."
        )
    return f"Play `{proposal.command_file}`: it separates {pair} by {apart}."


def notes_list(notes: Sequence[NoteEntry]) -> str:
    """What the data contract found and did, one line a note."""

    def place(note: NoteEntry) -> str:
        return " ".join(f"`{name}`" for name in (note.log, note.signal) if name)

    def said(note: NoteEntry) -> str:
        return note.message.removeprefix(f"{note.signal}: ")

    return "\n".join(f"- {place(note)}{': ' if place(note) else ''}{said(note)}" for note in notes)


def _how_to_look(report: GapReport) -> str:
    return f"`{view_command(report.run)}` opens the recording `review.rrd` beside this page."


def _section(title: str, body: str) -> str:
    return f"## {title}\n\n{body}" if body else ""
