"""Verb `train`: a policy, and beside it the distribution of the contexts that it is trained on."""

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import torch
from rich.console import Console
from rich.markdown import Markdown
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from dr_lab.collectors.collector import Policy
from dr_lab.envs.environment import Environment
from dr_lab.errors import ConfigError
from dr_lab.files import write_text
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.look import Look
from dr_lab.recorders.training import Curve
from dr_lab.recorders.training_review import TrainingRecord, write_training_review
from dr_lab.reports.plain import to_plain
from dr_lab.reports.quantity import number
from dr_lab.sweeps.progress import tell
from dr_lab.training.beginning import Beginning
from dr_lab.training.checkpoint import save
from dr_lab.training.episode_log import Finished
from dr_lab.training.episodes import described, keep_episodes, play_episodes
from dr_lab.training.plan import CHECKPOINT, POLICY, Plan, Training
from dr_lab.training.policy_snapshots import Choice, PolicySnapshots
from dr_lab.training.snapshots import Snapshots
from dr_lab.training.trainer import BatchWatch
from dr_lab.trajectory import Array

RESUMES_FROM = CHECKPOINT  # what a run folder must hold to be resumed
# Keys that may be others in a run that is gone on with; schedules that follow from `frames` stretch with it.
MAY_DIFFER = ("frames", "threads", "checkpoint_every", "recorder", "choice")
NOTHING_LEARNT = Beginning(run=None, distribution=False)
_DRAWS = 100_000  # of a distribution, for its mean and standard deviation: to 0.3 % of the latter
_NO_EPISODE = "No episode ended, so that no return is known; dr-lab evaluate plays whole ones."
_NOT_PLOTTED = ("iteration", "frames", "rollout_frames", "seconds", "episodes")


def train(
    plan: Plan,
    choice: Choice,
    recorder: Look,
    resume: str | None,
    run_dir: Path,
    final_share: float = 1.0,
    beginning: Beginning = NOTHING_LEARNT,
) -> dict[str, Any]:
    """Train a policy on a distribution of contexts, which may be learnt beside it.

    Files: ``metrics.csv`` (a row an iteration), ``checkpoint.pt`` (the last state, with the policies of the last
    checkpoints), ``policy.pt`` (that of them which is deployed), ``report.json``, ``report.md``, ``review.rrd`` and
    ``episodes.mcap`` (a few episodes of the trained policy). An interrupted run is continued by the same command with
    ``resume=<run folder>``, as if it had never stopped.

    Args:
        plan: what is trained, and on what.
        choice: how the policy that is deployed is chosen among the last.
        recorder: how the recording looks.
        resume: run folder of an interrupted training run with the same settings.
        run_dir: the run folder.
        final_share: share of the iterations whose episodes make up the final return, the last ones.
        beginning: what is taken over from a finished run; a run that is resumed has already done so.

    Returns:
        The report (schema dr_lab/train/1).

    Raises:
        ConfigError: the parts do not fit, or a number is out of its range.
        DataError: the run to be resumed, or begun from, has no readable checkpoint, or other settings.
    """
    if not 0.0 < final_share <= 1.0:
        raise ConfigError(f"final_share is {final_share:g}; expected a share above 0, 1 at most.")
    torch.set_num_threads(1)  # small networks gain nothing from a second thread; the physics has its own
    training = plan.assemble(run_dir / CHECKPOINT)
    snapshots = Snapshots(training.randomizer)
    policies = PolicySnapshots(training.algorithm, choice.snapshots)
    training.more.update(snapshots=snapshots, policies=policies)
    (run_dir / POLICY).unlink(missing_ok=True)  # of a run that ended here before
    if resume is None:
        beginning.apply(training, plan.seed)
        snapshots.take(0)
    else:
        training.trainer.resume(Path(resume).expanduser() / CHECKPOINT)
        _tell_of_nothing_left(training.trainer.frames, plan.frames, resume)
    _run(training, snapshots, policies, plan, run_dir)
    deployed, told = _choose(training, policies, choice, plan, run_dir)
    episodes = play_episodes(plan.env, deployed, training.randomizer, recorder.episodes, plan.seed, plan.threads)
    report = _report(training, snapshots, plan.env, episodes, run_dir)
    report |= {**told, "final_return": final_return(training.trainer.history, final_share)}
    return _finish(training, snapshots, report, recorder, (plan.env, episodes), run_dir)


def _choose(
    training: Training, policies: PolicySnapshots, choice: Choice, plan: Plan, run_dir: Path
) -> tuple[Policy, Mapping[str, Any]]:
    """Write the chosen policy down; gives it and what the report says of the choice."""
    found = policies.restored()
    chosen = choice.choose(found, plan.env, training.randomizer, plan.seed, plan.threads)
    save(run_dir / POLICY, policies.taken[chosen.index])
    told = {
        "snapshots": [{"frames": at.frames, "return": value} for at, value in zip(found, chosen.returns, strict=True)],
        "chosen": found[chosen.index].frames,
        "choice_frames": chosen.frames,
    }
    return found[chosen.index].deployed, told


def _tell_of_nothing_left(played: int, frames: int, resume: str) -> None:
    if played >= frames:
        Console().print(
            f"{resume} has played {played} control steps, and frames is {frames}: nothing is left to be trained. "
            "Raise frames to go on.",
            soft_wrap=True,
        )


def _run(training: Training, snapshots: Snapshots, policies: PolicySnapshots, plan: Plan, run_dir: Path) -> None:
    trainer = training.trainer
    try:
        with closing(trainer), _progress(plan.frames, trainer.frames) as show:

            def watch(figures: Mapping[str, float], finished: Finished) -> None:
                if training.learner.learns:
                    snapshots.take(int(figures["iteration"]))
                if trainer.due or trainer.frames >= plan.frames:
                    policies.take(trainer.frames)
                if trainer.due:
                    write_text(run_dir / "metrics.csv", metrics_csv(trainer.history))
                show(figures, finished)
                tell(int(figures["iteration"]), figures)

            trainer.run(plan.frames, watch)
    except KeyboardInterrupt:
        if (run_dir / CHECKPOINT).is_file():
            Console().print(f"Interrupted. To go on, add resume={run_dir}", soft_wrap=True)
        raise


def _finish(
    training: Training,
    snapshots: Snapshots,
    found: Mapping[str, Any],
    look: Look,
    shown: tuple[Environment, Sequence[Episode]],
    run_dir: Path,
) -> dict[str, Any]:
    """Write the report down in all its forms."""
    history, (env, episodes) = training.trainer.history, shown
    report = to_plain(dict(found))
    assert isinstance(report, dict)
    page = _page(report)
    write_text(run_dir / "metrics.csv", metrics_csv(history))
    write_text(run_dir / "report.json", json.dumps(report, ensure_ascii=False, indent=2) + "\n")
    write_text(run_dir / "report.md", page)
    keep_episodes(run_dir, env, episodes)
    marginals, pairs, pages = snapshots.marginals(), snapshots.pairs(), {"Report": page}
    record = TrainingRecord(env.name, _curves(history), marginals, pairs, episodes=episodes, pages=pages)
    write_training_review(run_dir / "review.rrd", record, look)
    Console().print(Markdown(page))
    return report


def _report(
    training: Training, snapshots: Snapshots, env: Environment, episodes: Sequence[Episode], run_dir: Path
) -> dict[str, Any]:
    history = training.trainer.history
    z = training.randomizer.sample([np.random.default_rng(0)] * _DRAWS)
    context = {
        p.name: {"unit": p.unit, "low": p.low, "high": p.high, **_moments(column)}
        for p, column in zip(env.space.parameters, z.T, strict=True)
    }
    for learned in snapshots.marginals():
        end = {"edges": learned.edges, "initial": learned.initial, "probability": learned.probability[-1]}
        context[learned.name] |= end
    return {
        "schema": "dr_lab/train/1",
        "verb": "train",
        "env": env.name,
        "algorithm": training.algorithm.name,
        "iterations": len(history),
        "frames": training.trainer.frames,
        "rollout_frames": int(history[-1]["rollout_frames"]),
        "seconds": history[-1]["seconds"],
        "infeasible_episodes": int(sum(map(_infeasible, history))),
        "final": history[-1],
        "context": context,
        "episodes": described(episodes),
        "checkpoint": CHECKPOINT,
        "policy": POLICY,
        "run": run_dir,
    }


def _moments(draws: Array) -> dict[str, float]:
    """Mean and standard deviation, exact where all draws are the same."""
    return {"mean": draws.mean(), "std": draws.std()} if np.ptp(draws) else {"mean": draws[0], "std": 0.0}


def final_return(history: Sequence[Mapping[str, float]], share: float) -> float | None:
    """Mean return of the feasible episodes that ended in the last iterations; None where none did.

    Args:
        history: figures of every iteration by name.
        share: of the iterations, the last ones, one at least.
    """
    last = history[-max(1, round(share * len(history))) :]
    feasible = [(row["episodes"] - _infeasible(row), row["episode_return"]) for row in last]
    known = [(count, value) for count, value in feasible if count]
    return sum(count * value for count, value in known) / sum(count for count, _ in known) if known else None


def _infeasible(row: Mapping[str, float]) -> float:
    """Number of infeasible episodes; a checkpoint of an earlier version counts them among the others."""
    return row.get("infeasible_episodes", 0.0)


def _page(report: Mapping[str, Any]) -> str:
    value = report["final_return"]
    lines = [
        f"# {report['algorithm']} on {report['env']}",
        "",
        f"{report['frames']} control steps in {report['seconds']:.0f} s, {report['iterations']} iterations. "
        + (_NO_EPISODE if value is None else f"Mean return of the episodes that ended last: {number(value)}."),
    ]
    lines += [
        "",
        f"Deployed is the policy of control step {report['chosen']}, the best of those that were kept "
        f"({len(report['snapshots'])}). Choosing took {report['choice_frames']} control steps of other episodes.",
    ]
    if report["rollout_frames"]:
        lines += ["", f"The distribution was learnt from further episodes: {report['rollout_frames']} control steps."]
    if report["infeasible_episodes"]:
        lines += ["", f"Episodes in infeasible contexts, which no mean return counts: {report['infeasible_episodes']}."]
    if report["context"]:
        lines += ["", "| parameter | mean | std | unit |", "|---|---|---|---|"]
        lines += [f"| {k} | {c['mean']:.4g} | {c['std']:.3g} | {c['unit']} |" for k, c in report["context"].items()]
    return "\n".join(lines) + "\n"


def metrics_csv(history: Sequence[Mapping[str, float]]) -> str:
    """One row an iteration; what an iteration does not know is empty.

    Args:
        history: figures by name.
    """
    columns = list(dict.fromkeys(name for row in history for name in row))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in history:
        writer.writerow(["" if np.isnan(row.get(name, np.nan)) else f"{row[name]:.10g}" for name in columns])
    return text.getvalue()


def _curves(history: Sequence[Mapping[str, float]]) -> list[Curve]:
    iteration = np.array([int(row["iteration"]) for row in history])
    names = dict.fromkeys(name for row in history for name in row if name not in _NOT_PLOTTED)
    return [Curve(name, "", iteration, np.array([row.get(name, np.nan) for row in history])) for name in names]


@contextmanager
def _progress(frames: int, done: int) -> Iterator[BatchWatch]:
    """A bar over control steps, with the mean return of the episodes that ended last."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.completed:.0f} of {task.total:.0f}"))
    with Progress(*columns, TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(), transient=True) as bar:
        task = bar.add_task("Training", total=frames, completed=done)

        def show(figures: Mapping[str, float], finished: Finished) -> None:
            del finished
            value = figures["episode_return"]
            label = "no episode ended" if np.isnan(value) else f"return {value:.1f}"
            bar.update(task, completed=figures["frames"], description=f"Training: {label}")

        yield show
