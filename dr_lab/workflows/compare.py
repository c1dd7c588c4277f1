"""Verb `compare`: measured beside simulated, and where the model fails."""

from pathlib import Path
from typing import Any

from dr_lab.diagnosis.fault_settings import FaultSettings
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.physics.model import Model
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import BEFORE
from dr_lab.trajectory import MeasurementSet
from dr_lab.workflows import entries
from dr_lab.workflows.calibrated import as_given
from dr_lab.workflows.finish import finish
from dr_lab.workflows.localised import failure
from dr_lab.workflows.study import prepare


def compare(
    model: Model,
    measurements: MeasurementSet,
    windows: WindowSettings,
    predicted: WindowSettings,
    solver: SolverSettings,
    evidence: EvidenceSettings,
    localise: LocaliseSettings,
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
    study = prepare(model, measurements, windows, predicted, solver, evidence, localise, faults, threads)
    z, (score, rung) = model.space.nominal, as_given(study)
    report = {
        **entries.header("compare", study),
        "verdict": None,
        "ladder": [rung],
        "remaining": entries.remaining(score.chi2, score.freedom, evidence),
        **failure(study, model, z),
    }
    return finish(study, report, {BEFORE: (model, z)}, run_dir, recorder)
