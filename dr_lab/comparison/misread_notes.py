"""Notes on channels that the model follows far better when they are read otherwise than declared."""

from collections.abc import Callable

from dr_lab.comparison.study import Study
from dr_lab.diagnosis.faults.unit_suspicion import UnitSuspicion, suspect_degrees, suspect_turned
from dr_lab.reports.gap_entries import NoteEntry


def misread_notes(study: Study) -> list[NoteEntry]:
    """Notes on angles that seem to be degrees, and on a channel that seems to count the other way."""
    return [*_degrees(study), *_turned(study)]


def _degrees(study: Study) -> list[NoteEntry]:
    found = _suspected(study, suspect_degrees)
    if found is None:
        return []
    names = ", ".join(found.channels)
    message = (
        f"{names} in radians, as declared, leave χ² {found.chi2:.3g}; read as degrees {found.chi2_read_anew:.3g}: the "
        "factor 57.3 = 180/π is suspected. Write unit: deg if the numbers are degrees."
    )
    return [NoteEntry(message, "unit")]


def _turned(study: Study) -> list[NoteEntry]:
    found = _suspected(study, suspect_turned)
    if found is None:
        return []
    (name,) = found.channels
    message = (
        f"{name}, as declared, leaves χ² {found.chi2:.3g}; with the other sign {found.chi2_read_anew:.3g}: it seems to "
        f"count the other way than the model. Turn its sign in measurements.outputs.{name}, or its axis in the model."
    )
    return [NoteEntry(message, "turned", signal=name)]


def _suspected(study: Study, suspect: Callable[..., UnitSuspicion | None]) -> UnitSuspicion | None:
    bench, settings = study.bench, study.settings
    return suspect(
        study.model, study.measurements, settings.faults.degrees, settings.windows, bench.solver, bench.threads
    )
