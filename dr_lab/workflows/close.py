"""Verb `close`: name the missing effect, add it, and repeat until nothing more is supported."""

from collections.abc import Mapping
from pathlib import Path

from dr_lab.comparison.climbing import climbed
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run
from dr_lab.comparison.ladder_report import Told, report_ladder
from dr_lab.comparison.lesson import lessons
from dr_lab.comparison.progress import screen
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.effects.catalogue import require_names
from dr_lab.effects.effect import Effect
from dr_lab.errors import ConfigError
from dr_lab.recorders.look import Look
from dr_lab.reports.gap import GapReport


def close(
    comparison: Comparison,
    effects: Mapping[str, Effect],
    next_experiment: ExperimentSettings,
    recorder: Look,
    most: int,
    run_dir: Path,
) -> GapReport:
    """Climb the ladder of models until the noise floor or until no effect is supported.

    Where a gap remains, the last rung is a force that is learned from the logs; it has a share in no verdict.

    Args:
        comparison: the model beside logs, and how they are compared.
        effects: the catalogue, by name.
        next_experiment: which experiments are tried where logs cannot separate two effects.
        recorder: how the recording looks.
        most: most effects that are added, one at several sites counted once; 0 ranks them, as `diagnose` does.
        run_dir: the run folder.

    Returns:
        The report (schema dr_lab/gap/1).

    Raises:
        ConfigError: `most` is negative.
    """
    if most < 0:
        raise ConfigError(f"most is {most}; expected the number of effects to add at most, 0 or more.")
    require_names(effects)
    with screen() as told:
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        study, ladder = climbed(study, effects, most=most, watch=told)
        learned = lessons(study, ladder.models[-1], told.phase) if most else ()
        return report_ladder(Told("close", learned), study, ladder, Run(run_dir, recorder, told), next_experiment)
