"""Faults of logs, said before anything is fitted and first in every report."""

from collections.abc import Sequence

from dr_lab.diagnosis.faults.data_faults import Fault
from dr_lab.reports.faults import DERIVED, FAULT, UNLOGGED, allowed_for, faults_by_signal
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.trajectory import MeasurementSet

UNDECIDED = "undecided"
BETWEEN = (UNLOGGED, UNDECIDED)  # that commands went on between their samples, or may have
_READINGS = (*BETWEEN, DERIVED)
_HEADINGS = {
    False: "**The logs seem faulty; mend this first, the rest depends on it:**",
    True: "What is wrong with the logs is allowed for here:",
}


def fault_notes(faults: Sequence[Fault], measured: MeasurementSet) -> list[NoteEntry]:
    """Notes on faults that the model shows, then on those that the data alone show."""
    shown = [
        NoteEntry(
            kind=FAULT,
            fault=fault.kind,
            log=fault.log,
            signal=fault.signal,
            message=f"{fault.message} ({fault.begin:.2f} to {fault.end:.2f} s) {fault.remedy}",
        )
        for fault in faults
    ]
    alone = [
        NoteEntry(
            kind=FAULT,
            fault=note.message.split(":")[0].lower(),
            log=log.name,
            signal=note.signal,
            message=note.message,
            count=note.count,
        )
        for log in (*measured.fit, *measured.held_out)
        for note in log.notes
        if note.kind == FAULT
    ]
    return [*shown, *alone]


def faults_markdown(notes: Sequence[NoteEntry]) -> str:
    """The faults among notes, a line for each signal, those that are allowed for last; empty where there is none."""
    told: dict[bool, list[str]] = {False: [], True: []}
    for first, *more in faults_by_signal(notes):
        others = ", ".join(str(note.log) for note in more)
        line = f"- `{first.log}`: {first.message}{f' The same in {others}.' if others else ''}"
        told[allowed_for(first, notes)].append(line)
    parts = [f"{heading}\n\n" + "\n".join(told[mended]) for mended, heading in _HEADINGS.items() if told[mended]]
    return "\n\n".join(parts)


def lines_markdown(notes: Sequence[NoteEntry]) -> str:
    """Which commands may have gone on between their samples, where no fault says so; empty where there is none."""
    faulty = {note.signal for note in notes if note.kind == FAULT}
    told = {note.signal: note.message for note in notes if note.kind in BETWEEN and note.signal not in faulty}
    if not told:
        return ""
    (_, message), *others = told.items()
    same = f" The same of {', '.join(str(name) for name, _ in others)}." if others else ""
    return f"How commands are read:\n\n- {message}{same}"


def known_faults(faults: Sequence[Fault], measured: MeasurementSet) -> list[NoteEntry]:
    """Notes on faults, on how the reading of the logs allows for some of them, and on what it leaves open."""
    logs = (*measured.fit, *measured.held_out)
    mends = [
        NoteEntry(note.message, note.kind, signal=note.signal)
        for log in logs
        for note in log.notes
        if note.kind in _READINGS
    ]
    return [*fault_notes(faults, measured), *mends]
