"""Verb `compare`: measured beside simulated, and where the model fails."""

from dataclasses import replace
from pathlib import Path

from dr_lab.comparison import entries
from dr_lab.comparison.calibrated import as_given
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run, answer, finish
from dr_lab.comparison.localised import failure
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import prepare
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import BEFORE
from dr_lab.reports.gap import GapReport


def compare(
    comparison: Comparison,
    recorder: Look,
    run_dir: Path,
) -> GapReport:
    """Compare the model as given with its held-out logs, or the fit logs where none is held out.

    Nothing is fitted but the windows' start states.

    Returns:
        The report (schema dr_lab/gap/1) whose ladder holds the one model.
    """
    with screen() as told:
        run = Run(run_dir, recorder, told)
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        told.phase("Comparing the model with the logs")
        z, (score, rung) = comparison.model.space.nominal, as_given(study)
        report = entries.begun("compare", study, [rung], score)
        answer(report, run)
        told.phase("Looking where the model fails")
        report = replace(report, failure=failure(study, study.model, z, score))
        return finish(study, report, {BEFORE: (study.model, z)}, run)
