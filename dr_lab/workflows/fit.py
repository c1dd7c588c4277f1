"""Verb `fit`: calibrate the plain model, no effect added."""

from dataclasses import replace
from pathlib import Path

from dr_lab.comparison import entries
from dr_lab.comparison.calibrated import as_given, calibrate, describe
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run, answer, finish
from dr_lab.comparison.inertia import inertia_entry
from dr_lab.comparison.localised import failure
from dr_lab.comparison.notes import fit_notes
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import prepare
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import AFTER, BEFORE
from dr_lab.reports.gap import GapReport


def fit(
    comparison: Comparison,
    recorder: Look,
    run_dir: Path,
) -> GapReport:
    """Fit the declared parameters: value ± std, scatter between logs (CV %), covariance, errors before and after.

    Returns:
        The report (schema dr_lab/gap/1).
    """
    with screen() as told:
        run = Run(run_dir, recorder, told)
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        told.phase("Calibrating the model")
        found = describe(study, calibrate(study))
        z, report = found.fitted_model.fit.z, entries.begun("fit", study, [found.rung], found.fitted_model.held_out)
        notes = (*fit_notes([found.fitted_model]), *report.notes)
        inertia = inertia_entry(found.fitted_model, found.estimate)
        report = replace(report, notes=notes, as_given=as_given(study)[1], inertia=inertia)
        answer(report, run)
        told.phase("Looking where the model fails")
        report = replace(report, failure=failure(study, study.model, z, found.fitted_model.held_out))
        models = {BEFORE: (study.model, comparison.model.space.nominal), AFTER: (study.model, z)}
        return finish(study, report, models, run, found.estimate)
