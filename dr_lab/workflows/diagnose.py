"""Verb `diagnose`: rank the catalogue on held-out logs and say which effect is missing."""

from collections.abc import Mapping
from pathlib import Path

from dr_lab.comparison.climbing import climbed
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run
from dr_lab.comparison.ladder_report import Told, report_ladder
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.effects.catalogue import require_names
from dr_lab.effects.effect import Effect
from dr_lab.recorders.look import Look
from dr_lab.reports.gap import GapReport


def diagnose(
    comparison: Comparison,
    effects: Mapping[str, Effect],
    next_experiment: ExperimentSettings,
    recorder: Look,
    run_dir: Path,
) -> GapReport:
    """Fit every effect at every site beside the calibrated model and judge.

    Returns:
        The report (schema dr_lab/gap/1); its ladder ends with the named effect, where there is one.
    """
    require_names(effects)
    with screen() as told:
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        study, ladder = climbed(study, effects, most=0, watch=told)
        return report_ladder(Told("diagnose"), study, ladder, Run(run_dir, recorder, told), next_experiment)
