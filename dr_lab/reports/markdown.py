"""`report.md`: what a run found, for a person; also the text shown inside the recording."""

from collections.abc import Mapping, Sequence
from typing import Any

from dr_lab.reports.ladder import candidate_name, failing, judged, scored
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


def report_markdown(report: Mapping[str, Any]) -> str:
    """Render a report of compare, fit, diagnose, add or close.

    Args:
        report: keys as in `gap.schema.json`; sections whose key is absent are left out.

    Returns:
        Markdown with tables and without mathematics, so that every viewer shows it.
    """
    title = " · ".join(dict.fromkeys(report[key] for key in ("model", "measurements", "verb") if report.get(key)))
    parameters = report["ladder"][-1]["parameters"]
    sections = [
        f"# {title}",
        verdict_markdown(report),
        _section("Ladder of models", ladder_table(report)),
        _section("Reasons", _reasons(report)),
        _section(f"Error by channel, on {scored(report)}", channel_table(report)),
        _section("Candidates", ranking_table(report.get("ranking", []), report.get("verdict"))),
        _section("Parameters", parameter_table(parameters)),
        _trades(report, parameters),
        _section("Parameters by log", per_log_table(parameters)),
        _section(f"Where the {failing(report)} fails", _where(report.get("where", []))),
        _section("Missing forces", _missing_forces(report.get("missing_force", []))),
        _section(f"Error of the {failing(report)} and horizon", horizon_table(report)),
        _section(f"Residual of the {failing(report)} and command", _correlations(report.get("input_correlation", []))),
        _section("Next experiment", _next_experiment(report.get("next_experiment"))),
        _section("Noise floor", noise_table(report["noise"])),
        _section("Notes", notes_list(report.get("notes", []))),
        _section("Clocks", clock_table(report.get("clocks", {}))),
        _section("How to look at it", _how_to_look(report)),
    ]
    return "\n\n".join(section for section in sections if section) + "\n"


def _reasons(report: Mapping[str, Any]) -> str:
    """Why each rung's verdict is what it is; the first rung's alone where there is but one."""
    rungs = report.get("rungs") or ([report] if report.get("reason") else [])
    told = [judged(rung.get("verdict") or "", report.get("verdict")) for rung in rungs]
    return "\n".join(f"- {word}: {rung['reason']}" for word, rung in zip(told, rungs, strict=True))


def _where(regions: Sequence[Mapping[str, Any]]) -> str:
    lines = [f"- `{row['signal']}`, {row['region']}: {percent(row['share'])} of its squared error" for row in regions]
    return "\n".join(lines)


def _trades(report: Mapping[str, Any], parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Which parameters trade against each other, which take an effect's place, and which intervals are doubtful."""
    worst = report.get("worst_direction") or {}
    lines = []
    if len(worst) > 1:
        told = " ".join(f"{'+' if value > 0 else '−'} {abs(value):.2f} `{name}`" for name, value in worst.items())
        lines.append(f"- The logs know least of {told.removeprefix('+ ')} (in widths of the bounds): these trade.")
    for row in report.get("ranking", []):
        if row.get("replaced_by"):
            takers = ", ".join(f"`{name}`" for name in row["replaced_by"])
            lines.append(f"- `{candidate_name(row)}` cannot be told from {takers}, which take its place.")
    doubted: dict[str, list[str]] = {}
    for name, row in parameters.items():
        for doubt in row.get("doubts", []):
            doubted.setdefault(doubt, []).append(f"`{name}`")
    lines += [f"- Do not trust the intervals of {', '.join(names)}: {doubt}." for doubt, names in doubted.items()]
    return "\n".join(lines)


def _missing_forces(rows: Sequence[Mapping[str, Any]]) -> str:
    """How much of the missing force the effects took away and how much they could have, and a formula of the rest."""
    lines = []
    for row in rows:
        could = "" if row["ceiling"] is None else f" (a force of the measured state could: {percent(row['ceiling'])})"
        sizes = " → ".join(f"{number(row[key], 3)}" for key in ("rms_first", "rms_last"))
        beyond = f"{row['unit']} RMS beyond the noise's {number(row['noise'], 3)}"
        explained = f"{percent(row['explained'])} explained{could}{_of_windows(row)}"
        lines.append(f"- `{row['joint']}`: {sizes} {beyond}, {explained}.")
        left = row["left"]
        if left and left["terms"]:
            terms = " ".join(_term(term, first=k == 0) for k, term in enumerate(left["terms"]))
            lines[-1] += f" {percent(left['share'])} of the rest follows F ≈ {terms} [{row['unit']}]."
    return "\n".join(lines)


def _of_windows(row: Mapping[str, Any]) -> str:
    return f", from {row['windows']} short windows" if row.get("windows") else ""


def _term(term: Mapping[str, Any], *, first: bool) -> str:
    value = term["coefficient"]
    sign = ("−" if value < 0 else "") if first else ("− " if value < 0 else "+ ")
    name = "" if term["term"] == "1" else f" {term['term']}"
    return f"{sign}{number(abs(value), 3)}{name}"


def _correlations(rows: Sequence[Mapping[str, Any]]) -> str:
    """Residuals that still follow a command, beyond the 99 % band of chance."""
    lines = [
        f"- The residual of `{row['signal']}` follows `{row['command']}` after {number(1e3 * row['peak_lag'], 3)} ms: "
        f"correlation {number(row['peak'], 2)}, chance stays below {number(row['band'], 2)}"
        for row in rows
        if row["significant"]
    ]
    return "\n".join(lines)


def _next_experiment(proposal: Mapping[str, Any] | None) -> str:
    if not proposal:
        return ""
    pair = " from ".join(f"`{effect}`" for effect in proposal["separates"][:2])
    apart = f"{number(proposal['sigma'], 2)} σ"
    if proposal["sigma"] < proposal.get("needed", 0.0):
        return (
            f"No command that was tried separates {pair}: `{proposal['command_file']}` comes farthest, with {apart}. "
            "To these sensors they may be the same; a further channel would tell them apart."
        )
    return f"Play `{proposal['command_file']}`: it separates {pair} by {apart}."


def notes_list(notes: Sequence[Mapping[str, Any]]) -> str:
    """What the data contract found and did, one line a note."""

    def place(note: Mapping[str, Any]) -> str:
        return " ".join(f"`{note[key]}`" for key in ("log", "signal") if note.get(key))

    def said(note: Mapping[str, Any]) -> str:
        return note["message"].removeprefix(f"{note.get('signal')}: ")

    return "\n".join(f"- {place(note)}{': ' if place(note) else ''}{said(note)}" for note in notes)


def _how_to_look(report: Mapping[str, Any]) -> str:
    return f"`{view_command(report.get('run', 'latest'))}` opens the recording `review.rrd` beside this page."


def _section(title: str, body: str) -> str:
    return f"## {title}\n\n{body}" if body else ""
