"""Verb `evaluate`: what a trained policy is worth, over contexts, on another machine, or as a beginning."""

import csv
import io
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import torch
from rich.console import Console
from rich.markdown import Markdown
from rich.progress import Progress as Bar

from dr_lab.collectors.collector import Policy
from dr_lab.distribution_learners.none import NoLearner
from dr_lab.errors import DataError
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Row, Subject
from dr_lab.files import write_text
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.recorders.look import Look
from dr_lab.recorders.training_review import TrainingRecord, write_training_review
from dr_lab.reports.plain import to_plain
from dr_lab.reports.quantity import number, titled
from dr_lab.reports.tables import table
from dr_lab.training.episodes import described, keep_episodes, play_episodes
from dr_lab.training.plan import CHECKPOINT, Plan, Training
from dr_lab.training.policy_snapshots import PolicySnapshot, PolicySnapshots
from dr_lab.training.trained_run import TrainedRun
from dr_lab.training.trainer import Trainer

_SHOWN = 40  # rows of the table in the page; all are in returns.csv


def evaluate(
    run: str,
    runs: str,
    evaluator: Evaluator,
    recorder: Look,
    seed: int,
    threads: int | None,
    compose: Callable[..., Mapping[str, Any]],
    run_dir: Path,
) -> dict[str, Any]:
    """Evaluate the policy that a training run left.

    Files: ``returns.csv`` (the evaluator's table), ``report.json``, ``report.md``, ``review.rrd``, ``episodes.mcap``.
    The latter two hold the evaluator's episodes or, where it keeps none, a few in contexts that were trained on.

    Args:
        run: folder of the training run, or ``latest`` for the newest below `runs`.
        runs: folder that collects training runs.
        evaluator: what is played and summed up.
        recorder: how the recording looks.
        seed: of the episodes that are shown.
        threads: C threads of the physics; None takes every core.
        compose: gives the arguments of a verb, built from its name, overrides and the folder that records them.
        run_dir: the run folder.

    Returns:
        The report (schema dr_lab/evaluate/1).

    Raises:
        DataError: there is no such run, or it has no readable checkpoint.
        ConfigError: the evaluator does not fit the task.
    """
    torch.set_num_threads(1)  # small networks gain nothing from a second thread; the physics has its own
    folder = trained(run, Path(runs))
    subject = subject_of(folder, compose, threads)
    with _progress() as progress:
        found = evaluator.evaluate(subject, run_dir, progress)
    if not found.episodes:
        setting, policy, contexts = subject.setting, subject.policy, subject.trained_on
        found = replace(found, episodes=play_episodes(setting, policy, contexts, recorder.episodes, seed, threads))
    values = {"trained": folder, "env": subject.setting.name, "evaluator": type(evaluator).__name__, "run": run_dir}
    report = _report(values, found)
    _write(run_dir, report, found, subject, recorder)
    return report


def trained(run: str, runs: Path) -> Path:
    """Folder of a training run.

    Raises:
        DataError: there is none.
    """
    if run == "latest":
        found = sorted(runs.rglob(CHECKPOINT), key=lambda path: path.stat().st_mtime)
        if not found:
            raise DataError(f"There is no training run below {runs}. Run dr-lab train first, or give run=FOLDER.")
        return found[-1].parent
    folder = Path(run).expanduser()
    remedy = "Give run=FOLDER of a training run, or run=latest."
    if not folder.is_dir():
        raise DataError(f"There is no folder {folder}. {remedy}")
    if not (folder / CHECKPOINT).is_file():
        raise DataError(f"{folder} holds no {CHECKPOINT}{_origin(folder)}. {remedy}")
    return folder


def _origin(folder: Path) -> str:
    """Which verb made a run folder, where its configuration says so in its first line, the command."""
    config = folder / "config.yaml"
    lines = config.read_text(encoding="utf-8", errors="replace").splitlines() if config.is_file() else []
    made = re.match(r"# dr-lab (\w+)", lines[0]) if lines else None
    return f"; it is that of a run of dr-lab {made[1]}" if made else ""


def subject_of(folder: Path, compose: Callable[..., Mapping[str, Any]], threads: int | None) -> Subject:
    """The policy of a training run, and what it takes to play it and to train it on.

    Args:
        folder: the training run.
        compose: gives the arguments of a verb, built from its name, overrides and the folder that records them.
        threads: C threads of the physics; None takes every core.

    Raises:
        DataError: the checkpoint cannot be read, or is not of what the configuration beside it describes.
    """
    recorded: Plan = compose("train", [], recorded=folder)["plan"]
    plan = replace(recorded, threads=threads)
    training = plan.assemble(None)
    left, snapshots = _restored(training, folder)
    training.trainer.close()

    def again(source: ContextSource, seed: int) -> tuple[Trainer, Policy]:
        further = replace(plan, randomizer=lambda _: source, distribution_learner=NoLearner, seed=seed)
        fresh = further.assemble(None)
        left.train_on(fresh.algorithm, seed)
        return fresh.trainer, fresh.algorithm.deployed

    contexts = training.randomizer
    return Subject(folder.name, plan.env, training.algorithm.deployed, again, threads, contexts, snapshots)


def _restored(training: Training, folder: Path) -> tuple[TrainedRun, list[PolicySnapshot]]:
    """Put algorithm and distribution into the state that a run left; gives that, and the policies that it kept."""
    left, policies = TrainedRun.load(folder), PolicySnapshots(training.algorithm, 0)  # takes none
    try:
        left.restore(training.algorithm)
        training.learner.load_state_dict(left.last["learner"])
        policies.load_state_dict(left.last["policies"])
        snapshots = policies.restored()
    except (KeyError, RuntimeError, TypeError, ValueError) as error:
        raise DataError(
            f"{folder / CHECKPOINT} does not fit {folder / 'config.yaml'}, or is of another version of dr_lab: "
            f"{' '.join(str(error).split())} Give run=FOLDER of a training run as it was left, or train again."
        ) from error
    return left, snapshots


def _report(values: Mapping[str, Any], found: Evaluation) -> dict[str, Any]:
    rows = [dict(row) for row in found.rows]
    own = {"figures": dict(found.figures), "units": dict(found.units), "rows": rows}
    own["episodes"] = described(found.episodes)
    return cast(dict[str, Any], to_plain({"schema": "dr_lab/evaluate/1", "verb": "evaluate", **values, **own}))


def _write(run_dir: Path, report: Mapping[str, Any], found: Evaluation, subject: Subject, look: Look) -> None:
    page = _page(report, subject, found.told)
    write_text(run_dir / "returns.csv", _csv(found.rows))
    write_text(run_dir / "report.json", json.dumps(report, ensure_ascii=False, indent=2) + "\n")
    write_text(run_dir / "report.md", page)
    keep_episodes(run_dir, subject.setting, found.episodes)
    name = f"{subject.setting.name} · {subject.name}"
    record = TrainingRecord(name, found.curves, grids=found.grids, episodes=found.episodes, pages={"Report": page})
    write_training_review(run_dir / "review.rrd", record, look)
    Console().print(Markdown(page))


def _page(report: Mapping[str, Any], subject: Subject, told: str) -> str:
    figures = [[name.replace("_", " "), number(value)] for name, value in report["figures"].items()]
    rows = report["rows"]
    columns = list(rows[0]) if rows else []
    header = [titled(name, report["units"].get(name, "")) for name in columns]
    cells = [[_cell(row[name]) for name in columns] for row in rows[:_SHOWN]]
    more = f"\n\n… and {len(rows) - _SHOWN} more in returns.csv." if len(rows) > _SHOWN else ""
    title = f"# What {subject.name} on {subject.setting.name} returns"
    return f"{title}\n\n{told}\n\n{table(['figure', 'value'], figures)}\n\n{table(header, cells)}{more}\n"


def _csv(rows: Sequence[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]) if rows else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _cell(value: float | str | None) -> str:
    return value if isinstance(value, str) else number(value)


@contextmanager
def _progress() -> Iterator[Progress]:
    with Bar(transient=True) as bar:
        task = bar.add_task("Evaluating", total=1.0)
        yield lambda share: bar.update(task, completed=share)
