"""What is wrong with the logs, in a line: the first thing that a reader of a report must know."""

from collections.abc import Sequence

from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.reports.quantity import counted

FAULT = "fault"
UNLOGGED, DERIVED = "unlogged", "derived"  # notes on what the reading of the logs allows for


def faults_told(notes: Sequence[NoteEntry]) -> str:
    """That the logs must be mended, and what is wrong with them; empty where nothing is."""
    open_ones = [note for note in notes if note.kind == FAULT and not allowed_for(note, notes)]
    if not open_ones:
        return ""
    return f"**The logs seem faulty:** {faults_line(open_ones)}. Mend this first: what follows may come of it."


def faults_line(notes: Sequence[NoteEntry]) -> str:
    """What is wrong with which signal of how many logs."""
    told = []
    for first, *more in faults_by_signal(notes):
        allowed = ", allowed for" if allowed_for(first, notes) else ""
        told.append(
            " ".join(filter(None, (first.fault, first.signal))) + f" ({counted(1 + len(more), 'log')}{allowed})"
        )
    return ", ".join(told)


def faults_by_signal(notes: Sequence[NoteEntry]) -> list[list[NoteEntry]]:
    """The notes on one fault of one signal together, one for each log."""
    found: dict[tuple[str | None, str | None], list[NoteEntry]] = {}
    for note in notes:
        if note.kind == FAULT:
            found.setdefault((note.signal, note.fault), []).append(note)
    return [*found.values()]


def allowed_for(fault: NoteEntry, notes: Sequence[NoteEntry]) -> bool:
    """Whether the signal is left out, or its commands are read as they were sent; a log's copy counts all the same."""
    kinds = {note.kind for note in notes if note.signal == fault.signal}
    return (DERIVED in kinds and fault.fault != "copied") or (UNLOGGED in kinds and fault.fault == "decimated")
