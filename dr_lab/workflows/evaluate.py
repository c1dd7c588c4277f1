"""Verb `evaluate`: what a trained policy is worth, over contexts, on another machine, or as a beginning."""

from dataclasses import replace
from pathlib import Path

import torch

from dr_lab.bounds import Natural
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Table
from dr_lab.evaluators.trained_run import Compose, TrainedRun, subject_of
from dr_lab.files import write_text
from dr_lab.recorders.look import Look
from dr_lab.recorders.training_review import TrainingRecord
from dr_lab.reports.csv_rows import rows_csv
from dr_lab.reports.evaluate import SCHEMA, EvaluateReport
from dr_lab.reports.evaluate_page import evaluate_page
from dr_lab.reports.plain import finite
from dr_lab.training.episodes import described, play_episodes
from dr_lab.training.finish import finish
from dr_lab.training.progress import progress


def evaluate(
    trained: TrainedRun, evaluator: Evaluator, recorder: Look, seed: Natural, compose: Compose, run_dir: Path
) -> EvaluateReport:
    """Evaluate the policy that a training run left.

    Files: ``returns.csv`` (the evaluator's table), maybe a shorter one, ``report.json``, ``report.md``,
    ``report.html``, ``review.rrd``, ``episodes.mcap``. The latter two hold the evaluator's episodes or, where it keeps
    none, a few in contexts that were trained on.

    Args:
        trained: the training run.
        evaluator: what is played and summed up.
        recorder: how the recording looks.
        seed: of the episodes that are shown.
        compose: gives the arguments of a verb, built from its name, overrides and the folder that records them.
        run_dir: the run folder.

    Raises:
        DataError: there is no such run, or it has no readable checkpoint.
        ConfigError: the evaluator does not fit the task.
    """
    torch.set_num_threads(1)  # small networks gain nothing from a second thread; the physics has its own
    folder = trained.folder()
    subject = subject_of(folder, compose, trained.threads)
    setting = subject.setting
    with progress(1.0) as show:
        found = evaluator.evaluate(subject, run_dir, lambda share: show(share, "Evaluating"))
    if not found.episodes:
        source, count = subject.trained_on, recorder.episodes
        shown = play_episodes(setting, subject.policy, source, count, seed, subject.threads)
        found = replace(found, episodes=shown)
    report = _report(folder, setting.name, evaluator, found, run_dir)
    name = f"{setting.name} · {subject.name}"
    parts = {"grids": found.grids, "matrices": found.matrices, "gains": found.gains, "ways": found.ways}
    parts |= {"samples": found.samples}
    record = TrainingRecord(name, found.curves, episodes=found.episodes, **parts)
    every = Table("returns.csv", found.rows)
    shown = found.summary or every
    for each in filter(None, (every, found.summary)):
        write_text(run_dir / each.file, rows_csv(each.rows))
    page = evaluate_page(report, found.told, shown.on_page(), shown.file)
    finish(run_dir, report, page, setting, record, recorder)
    return report


def _report(trained: Path, env: str, evaluator: Evaluator, found: Evaluation, run_dir: Path) -> EvaluateReport:
    return finite(
        EvaluateReport(
            schema=SCHEMA,
            verb="evaluate",
            trained=str(trained),
            env=env,
            evaluator=type(evaluator).__name__,
            figures=found.figures,
            rows=tuple(found.rows),
            run=str(run_dir),
            units=found.units,
            episodes=described(found.episodes),
        )
    )
