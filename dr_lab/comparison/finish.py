"""The end of every comparing verb: the run folder's files, and what is said on the screen."""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from dr_lab.comparison.export import write_context, write_model, write_rollout
from dr_lab.comparison.notes import DISAGREEING
from dr_lab.comparison.overlays import missing, overlay, play_log, shown_logs
from dr_lab.comparison.plain_file import EXPORT, file_note
from dr_lab.comparison.progress import Screen
from dr_lab.comparison.study import Study
from dr_lab.comparison.write_simulated import write_simulated
from dr_lab.effects.learned_force import write_learned_forces
from dr_lab.effects.residual_force import learned_forces
from dr_lab.html.gap_page import write_gap_page
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.mjcf import mjcf
from dr_lab.physics.model import Model
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import AFTER, BEFORE
from dr_lab.recorders.review import write_review
from dr_lab.reports.calibration import given_values
from dr_lab.reports.faults import FAULT
from dr_lab.reports.gap import GapReport
from dr_lab.reports.gap_entries import TRADE, NoteEntry
from dr_lab.reports.ladder import failing, kept_effects
from dr_lab.reports.markdown import beside_learned, doubtful_intervals, notes_list, report_markdown
from dr_lab.reports.plain import finite
from dr_lab.reports.quantity import counted, percent
from dr_lab.reports.rankings import naming
from dr_lab.reports.report import write_report
from dr_lab.reports.tables import ladder_table, noise_included, parameter_table, ranking_summary
from dr_lab.reports.verdict import verdict_markdown
from dr_lab.trajectory import Array, Log

_SHOWN = 6  # candidates on the screen
_SHOWN_LATER = 3  # candidates beside each later model that got an effect
_LISTED = 12  # parameters on the screen
_NOTED = 4  # notes on the screen
_OF_FILES = ("separator", "encoding", "cut")  # kinds of notes that say how a file was read


@dataclass(frozen=True)
class Run:
    """Where the results of a verb go.

    Attributes:
        folder: the run folder.
        look: how the recording looks.
        screen: where the user is told.
    """

    folder: Path
    look: Look
    screen: Screen


def answer(report: GapReport, run: Run) -> None:
    """Print what was found, as soon as it is known: verdict, models, parameters and ranking.

    Args:
        report: what is known of these; the rest may come later.
        run: where it is printed.
    """
    known = finite(report)
    parts = [verdict_markdown(known), ladder_table(known), _parameters(known), _candidates(known)]
    run.screen.show(_paragraphs(parts))


def save(report: GapReport, run: Run) -> None:
    """Write what is known of a report, in case that what still takes minutes is interrupted."""
    write_report(run.folder, _completed(report, [], run.folder))


def finish(
    study: Study,
    report: GapReport,
    models: Mapping[str, tuple[Model, Array]],
    run: Run,
    estimate: ContextEstimate | None = None,
) -> GapReport:
    """Write the run folder and print where the model fails and what must be known.

    Files: ``report.json``, ``report.md``, ``report.html``, ``metrics.csv``, ``review.rrd``, ``simulated.mcap``; with an
    improved model (role ``after``) also ``model.xml``, ``rollout.npz`` (where a log is shown) and ``context.yaml``, and
    ``residual_force.json`` where it has learned forces.

    Args:
        study: model and logs.
        report: what was found.
        models: by role (``before``, ``after``) a model and its context.
        run: where the results go.
        estimate: the improved model's fitted context.

    Returns:
        The report as written.
    """
    folder, longest = run.folder, run.look.longest
    run.screen.phase("Writing the report")
    shown, notes = _export(study, models, folder, report.ladder[-1].held_out.chi2)
    if estimate is not None:
        write_context(folder / "context.yaml", estimate)
    logs = shown_logs(study, longest)
    written = _completed(report, [*notes, *_shortened(study, logs, longest)], folder)
    write_report(folder, written)  # first, so that no fault of a recording costs the hours before it
    run.screen.phase("Writing the recordings")
    _record(study, written, logs, (models, shown), run)
    if told := rest(written):
        run.screen.show(told)
    return written


def _record(
    study: Study,
    written: GapReport,
    logs: Sequence[Log],
    models: tuple[Mapping[str, tuple[Model, Array]], Mapping[str, tuple[Model, Array]]],
    run: Run,
) -> None:
    """Write what is drawn of some logs; by role the models as found, whose forces are shown, and as they are played."""
    (found, shown), folder, look = models, run.folder, run.look
    played, forces = [play_log(study, log, shown) for log in logs], missing(study, found)
    overlays = [overlay(study, log, p, forces, look) for log, p in zip(logs, played, strict=True)]
    write_gap_page(folder / "report.html", written, overlays, look)
    if AFTER in shown and played:
        write_rollout(folder / "rollout.npz", played[0][AFTER])
    write_review(folder / "review.rrd", written, report_markdown(written), overlays, study.compiled, look)
    write_simulated(folder / "simulated.mcap", overlays, _attachments(folder, shown), _metadata(written))


def _completed(report: GapReport, notes: Sequence[NoteEntry], run_dir: Path) -> GapReport:
    """The report as it is written: all notes, those that matter most first; finite.

    First are faults, logs that disagree and what holds of all logs; last is what befell candidates that are rejected.
    """
    kept = kept_effects(report)
    every = sorted([*report.notes, *notes], key=lambda note: _importance(note, kept))
    return finite(replace(report, notes=tuple(every), run=str(run_dir)))


def _importance(note: NoteEntry, kept: Container[str]) -> tuple[bool, ...]:
    first = (note.kind != kind for kind in (FAULT, DISAGREEING, EXPORT))
    return (*first, not _concerns(note, kept), note.kind in _OF_FILES, note.log is not None)


def _concerns(note: NoteEntry, kept: Container[str]) -> bool:
    """Whether a note is about more than the fit of a candidate that is not in the answer."""
    return note.effect is None or note.effect in kept


def _shortened(study: Study, shown: Sequence[Log], longest: float) -> list[NoteEntry]:
    """Notes on logs of which the recordings show the beginning alone, or nothing."""
    ends = {log.name: _end(log) for log in shown}
    notes = []
    for log in study.measurements.held_out or study.measurements.fit:
        if log.name not in ends:
            message = (
                f"The recordings leave it out: it holds no gapless window within recorder.longest={longest:g} s. "
                "Show more seconds, or shorten windows.length."
            )
        elif ends[log.name] < _end(log):
            message = (
                f"The recordings show it up to {ends[log.name]:.0f} s of {_end(log):.0f} s; recorder.longest=… shows "
                "more."
            )
        else:
            continue
        notes.append(NoteEntry(message, "shown", log=log.name))
    return notes


def _end(log: Log) -> float:
    return max(signal.time[-1] for signal in log.outputs.values())


def rest(report: GapReport) -> str:
    """Where the model fails, and notes on the answer, for the screen; those on rejected candidates are in the file."""
    where = [f"- {r.signal}, {r.region}: {percent(r.share or 0.0)} of its squared error" for r in report.failing.where]
    parts = [f"Where the {failing(report)} fails:\n\n" + "\n".join(where[:3]) if where else ""]
    notes = [note for note in report.notes if note.kind not in (FAULT, TRADE)]  # those were shown before
    kept = kept_effects(report)
    told = [note for note in notes if _concerns(note, kept)][:_NOTED]
    left = f"- … and {len(notes) - len(told)} more in report.md" if len(notes) > len(told) else ""
    listed = "\n".join(filter(None, [notes_list(told), left]))
    parts.append(f"Notes:\n\n{listed}" if notes else "")
    return _paragraphs(parts)


def _paragraphs(parts: Sequence[str]) -> str:
    return "\n\n".join(part for part in parts if part.strip())


def _candidates(report: GapReport) -> str:
    """The first candidates beside each model that got an effect; one line where none was worth a fit."""
    ranking = report.judged.ranking
    if ranking and not any(row.fitted for row in ranking):
        most = max(row.predicted_gain or 0.0 for row in ranking)
        effects = counted(len(ranking), "effect")
        return f"No candidate was worth a fit: of {effects} none promised more than {percent(max(most, 0.0))}."
    tables = naming(report)
    shown = [each.rows[: _SHOWN if k == 0 else _SHOWN_LATER] for k, each in enumerate(tables)]
    titles = [f"Beside the {each.model}:\n\n" if len(tables) > 1 else "" for each in tables]
    told = [
        title + ranking_summary(rows, report.verdict, report.judged.confidence)
        for title, rows in zip(titles, shown, strict=True)
    ]
    left = sum(len(each.rows) - len(rows) for each, rows in zip(tables, shown, strict=True))
    return _paragraphs([*told, f"… and {left} more in report.md." if left else "", noise_included(report)])


def _parameters(report: GapReport) -> str:
    """The last model's parameters without a learned force, those of effects first, and what is doubtful of them."""
    last = report.catalogued[-1]
    if last.fit is None:
        return ""
    found = sorted(last.parameters.items(), key=lambda item: "@" not in item[0])
    told, given = dict(found[:_LISTED]), given_values(report)
    of_effects = {name: row for name, row in told.items() if name not in given}
    own = {name: row for name, row in told.items() if name in given}
    tables = [parameter_table(rows, given) for rows in (of_effects, own) if rows]
    left = f"… and {len(found) - _LISTED} more in report.md." if len(found) > _LISTED else ""
    trades = [f"- {note.message}" for note in report.notes if note.kind == TRADE]
    return _paragraphs([*tables, left, "\n".join([*trades, *beside_learned(report), *doubtful_intervals(told)])])


def _export(
    study: Study, models: Mapping[str, tuple[Model, Array]], run_dir: Path, chi2: float | None
) -> tuple[dict[str, tuple[Model, Array]], list[NoteEntry]]:
    """Write the improved model, where there is one, and let the file take its place; notes on what the file lacks.

    Learned forces are written beside it. The model leaves `chi2`.
    """
    if AFTER not in models:
        return dict(models), []
    if forces := learned_forces(models[AFTER][0]):
        write_learned_forces(run_dir, forces)
    exported, lacking = write_model(run_dir / "model.xml", *models[AFTER])
    notes = [NoteEntry(sentence, EXPORT) for sentence in lacking]
    if lacking:
        notes.append(file_note(study, run_dir / "model.xml", exported, chi2))
    return {**models, AFTER: (exported, exported.space.nominal)}, notes


def _attachments(run_dir: Path, shown: Mapping[str, tuple[Model, Array]]) -> dict[str, bytes]:
    """The run's configuration, and the model: the improved one where there is one, else the one that was compared."""
    found = (run_dir / name for name in ("model.xml", "config.yaml"))
    return {"model.xml": mjcf(*shown[BEFORE]).encode()} | {p.name: p.read_bytes() for p in found if p.is_file()}


def _metadata(report: GapReport) -> dict[str, str]:
    keys = ("schema", "verb", "model", "measurements", "verdict", "run")
    return {key: value for key in keys if (value := getattr(report, key))}
