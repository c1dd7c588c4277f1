"""Verb `compare`: measured beside simulated, and where the model fails."""

from pathlib import Path
from typing import Any

from dr_lab.comparison import entries
from dr_lab.comparison.calibrated import as_given
from dr_lab.comparison.finish import Run, answer, finish
from dr_lab.comparison.localised import failure
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.physics.model import Model
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import BEFORE
from dr_lab.trajectory import MeasurementSet


def compare(
    model: Model,
    measurements: MeasurementSet,
    windows: WindowSettings,
    predicted: WindowSettings,
    solver: SolverSettings,
    evidence: EvidenceSettings,
    localise: LocaliseSettings,
    model_check: ModelCheckSettings,
    faults: FaultSettings,
    recorder: Look,
    threads: int | None,
    run_dir: Path,
) -> dict[str, Any]:
    """Compare the model as given with its held-out logs, or the fit logs where none is held out.

    Nothing is fitted but the windows' start states.

    Returns:
        The report (schema dr_lab/gap/1) whose ladder holds the one model.
    """
    with screen() as told:
        run = Run(run_dir, recorder, told)
        told.phase("Cutting the logs into windows")
        study = prepare(
            model, measurements, windows, predicted, solver, evidence, localise, model_check, faults, threads
        )
        told.phase("Comparing the model with the logs")
        z, (score, rung) = model.space.nominal, as_given(study)
        report = {
            **entries.header("compare", study),
            "verdict": None,
            "ladder": [rung],
            "remaining": entries.remaining(score, evidence),
        }
        answer(report, run)
        told.phase("Looking where the model fails")
        report |= failure(study, study.model, z)
        return finish(study, report, {BEFORE: (study.model, z)}, run)
