"""Faults of logs, said before anything is fitted and first in every report."""

from collections.abc import Sequence

from rich.console import Console
from rich.markdown import Markdown

from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.trajectory import MeasurementSet

KIND = "fault"


def fault_notes(faults: Sequence[Fault], measured: MeasurementSet) -> list[NoteEntry]:
    """Notes on faults that the model shows, then on those that the data alone show."""
    shown = [
        NoteEntry(
            kind=KIND,
            fault=fault.kind,
            log=fault.log,
            signal=fault.signal,
            message=f"{fault.message} ({fault.begin:.2f} to {fault.end:.2f} s) {fault.remedy}",
        )
        for fault in faults
    ]
    alone = [
        NoteEntry(
            kind=KIND,
            fault=note.message.split(":")[0].lower(),
            log=log.name,
            signal=note.signal,
            message=note.message,
            count=note.count,
        )
        for log in (*measured.fit, *measured.held_out)
        for note in log.notes
        if note.kind == KIND
    ]
    return [*shown, *alone]


def faults_markdown(notes: Sequence[NoteEntry]) -> str:
    """The faults among a report's notes, one line for each signal; empty where there is none."""
    lines: dict[tuple[str | None, str | None], list[NoteEntry]] = {}
    for note in notes:
        if note.kind == KIND:
            lines.setdefault((note.signal, note.fault), []).append(note)
    told = []
    for first, *more in lines.values():
        others = ", ".join(str(note.log) for note in more)
        told.append(f"- `{first.log}`: {first.message}{f' The same in {others}.' if others else ''}")
    if not told:
        return ""
    return "**The logs seem faulty; mend this first, the rest depends on it:**\n\n" + "\n".join(told)


def say_faults(faults: Sequence[Fault], measured: MeasurementSet) -> None:
    """Print the faults."""
    told = faults_markdown(fault_notes(faults, measured))
    if told:
        Console().print(Markdown(told))
