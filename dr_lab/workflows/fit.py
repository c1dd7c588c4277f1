"""Verb `fit`: calibrate the plain model, no effect added."""

from pathlib import Path
from typing import Any

from dr_lab.comparison import entries
from dr_lab.comparison.calibrated import as_given, calibrate, describe
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run, answer, finish
from dr_lab.comparison.localised import failure
from dr_lab.comparison.notes import fit_notes
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import prepare
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import AFTER, BEFORE


def fit(
    comparison: Comparison,
    recorder: Look,
    run_dir: Path,
) -> dict[str, Any]:
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
        z, score, header = found.explained.fit.z, found.explained.held_out, entries.header("fit", study)
        report = {
            **header,
            "notes": [*fit_notes([found.explained]), *header["notes"]],
            "verdict": None,
            "as_given": as_given(study)[1],
            "ladder": [found.rung],
            "remaining": entries.remaining(score, study.bench.evidence),
        }
        answer(report, run)
        told.phase("Looking where the model fails")
        report |= failure(study, study.model, z)
        models = {BEFORE: (study.model, comparison.model.space.nominal), AFTER: (study.model, z)}
        return finish(study, report, models, run, found.estimate)
