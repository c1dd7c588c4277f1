"""A note on channels that the model follows far better when they are read otherwise than declared."""

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.faults.unit_suspicion import FewWindows, suspect_degrees, suspect_misread
from dr_lab.reports.gap_entries import NoteEntry


def misread_notes(study: Study) -> list[NoteEntry]:
    """A note on angles that seem to be degrees, else on a channel of another sign or unit; empty where none is."""
    settings, bench = study.settings, study.bench
    few = FewWindows(study.model, settings.faults.reading, settings.windows, bench.solver, bench.threads)
    found = suspect_degrees(few, study.measurements) or suspect_misread(few, study.measurements)
    return [] if found is None else [NoteEntry(found.message, "turned" if found.turned else "unit")]
