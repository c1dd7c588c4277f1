"""Verb `close`: name the missing effect, add it, and repeat until nothing more is supported."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from dr_lab.comparison.climbing import climbed
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.finish import Run
from dr_lab.comparison.kept_climbs import UNFINISHED, KeptClimbs
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
from dr_lab.reports.typed import typed
from dr_lab.stopping import Terminated

RESUMES_FROM = UNFINISHED  # what a run folder must hold to be resumed
MAY_DIFFER = ("threads", "recorder", "next_experiment")  # keys that may be others in a run that is gone on with


def close(
    comparison: Comparison,
    effects: Mapping[str, Effect],
    next_experiment: ExperimentSettings,
    recorder: Look,
    most: int,
    run_dir: Path,
    resume: str | None = None,
) -> GapReport:
    """Climb the ladder of models until the noise floor or until no effect is supported.

    README, "What a run leaves", says which files. An interrupted run is continued by the same command with
    ``resume=<run folder>``, from the last rung that it judged, and ends as if it had never stopped.

    Where a gap remains, the last rung is a force that is learned from the logs; it has a share in no verdict.

    Args:
        comparison: the model beside logs, and how they are compared.
        effects: the catalogue, by name.
        next_experiment: which experiments are tried where logs cannot separate two effects.
        recorder: how the recording looks.
        most: most effects that are added, one at several sites counted once; 0 ranks them, as `diagnose` does.
        run_dir: the run folder.
        resume: run folder of an interrupted run with the same settings.

    Returns:
        The report (schema dr_lab/gap/1).

    Raises:
        ConfigError: `most` is negative, or no run is there to go on with.
        DataError: the run to go on with had other logs or another model file.
    """
    if most < 0:
        raise ConfigError(f"most is {most}; expected the number of effects to add at most, 0 or more.")
    require_names(effects)
    kept = KeptClimbs(run_dir, None if resume is None else Path(resume).expanduser())
    with screen() as told, _to_go_on(kept, run_dir):
        told.phase("Cutting the logs into windows")
        study = prepare(comparison)
        study, ladder = climbed(study, effects, most=most, watch=told, kept=kept)
        learned = lessons(study, ladder.models[-1], told.phase) if most else ()
        report = report_ladder(Told("close", learned), study, ladder, Run(run_dir, recorder, told), next_experiment)
    kept.clear()
    return report


@contextmanager
def _to_go_on(kept: KeptClimbs, run_dir: Path) -> Iterator[None]:
    """Say how to go on with a run that is interrupted."""
    try:
        yield
    except (KeyboardInterrupt, Terminated):
        if kept.begun:
            print(f"Interrupted. To go on, add {typed('resume', run_dir)}")
        raise
