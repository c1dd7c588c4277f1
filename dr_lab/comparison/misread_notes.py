"""Notes on channels that the model follows far better when they are read otherwise than declared."""

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.faults.unit_suspicion import suspect_degrees, suspect_misread
from dr_lab.reports.gap_entries import NoteEntry


def misread_notes(study: Study) -> list[NoteEntry]:
    """Notes on angles that seem to be degrees, and on a channel of another sign or unit."""
    rules, windows, bench = study.settings.faults.degrees, study.settings.windows, study.bench
    found = [
        suspect(study.model, study.measurements, rules, windows, bench.solver, bench.threads)
        for suspect in (suspect_degrees, suspect_misread)
    ]
    return [NoteEntry(each.message, "turned" if each.turned else "unit") for each in found if each is not None]
