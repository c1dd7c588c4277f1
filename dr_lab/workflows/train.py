"""Verb `train`: a policy, and beside it the distribution of the contexts that it is trained on."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from rich.console import Console

from dr_lab.collectors.collector import Policy
from dr_lab.comparison.export import write_context
from dr_lab.errors import ConfigError
from dr_lab.files import write_text
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.context_file import FILE as CONTEXT
from dr_lab.randomizers.gaussian import GaussianRandomizer
from dr_lab.recorders.look import Look
from dr_lab.recorders.training_review import TrainingRecord
from dr_lab.reports.train import ChoiceEntry, SnapshotEntry, TrainReport
from dr_lab.reports.train_page import train_page
from dr_lab.reports.typed import typed
from dr_lab.stopping import stop_if_asked
from dr_lab.sweeps.progress import tell
from dr_lab.training.beginning import Beginning
from dr_lab.training.checkpoint import save
from dr_lab.training.drawn_contexts import FILE as DRAWN
from dr_lab.training.drawn_contexts import DrawnContexts
from dr_lab.training.episode_log import Finished
from dr_lab.training.episodes import play_episodes
from dr_lab.training.finish import finish
from dr_lab.training.history import curves, metrics_csv
from dr_lab.training.ladder import declines
from dr_lab.training.plan import CHECKPOINT, POLICY, Plan, Training
from dr_lab.training.policy_snapshots import Choice, PolicySnapshots
from dr_lab.training.progress import progress
from dr_lab.training.report import train_report
from dr_lab.training.snapshots import Snapshots

RESUMES_FROM = CHECKPOINT  # what a run folder must hold to be resumed
# Keys that may be others in a run that is gone on with; schedules that follow from `frames` stretch with it.
MAY_DIFFER = ("frames", "threads", "device", "checkpoint_every", "recorder", "choice")
NOTHING_LEARNT = Beginning(run=None, distribution=False)


def train(
    plan: Plan, choice: Choice, recorder: Look, resume: str | None, run_dir: Path, beginning: Beginning = NOTHING_LEARNT
) -> TrainReport:
    """Train a policy on a distribution of contexts, which may be learnt beside it.

    README, "What a run leaves", says which files. An interrupted run is continued by the same command with
    ``resume=<run folder>``, as if it had never stopped.

    Args:
        plan: what is trained, and on what.
        choice: how the policy that is deployed is chosen among the last.
        recorder: how the recording looks.
        resume: run folder of an interrupted training run with the same settings.
        run_dir: the run folder.
        beginning: what is taken over from a finished run; a run that is resumed has already done so.

    Raises:
        ConfigError: the parts do not fit, a number is out of its range, or nothing would be learned of a
            policy or a distribution.
        DataError: the run to be resumed, or begun from, has no readable checkpoint, or other settings.
    """
    torch.set_num_threads(1)  # small networks gain nothing from a second thread; the physics has its own
    checkpoint = run_dir / CHECKPOINT
    training = beginning.assemble(plan, checkpoint) if resume is None else plan.assemble(checkpoint)
    snapshots, policies, drawn = _noted(training, choice)
    if resume is None:
        _require_learnt(training, plan.frames)
        snapshots.take(0)
    else:
        _go_on(training, plan, resume)
    _run(training, snapshots, policies, plan, run_dir)
    deployed, chosen = _deploy(training, policies, choice, plan, run_dir)
    episodes = play_episodes(plan.env, deployed, training.randomizer, recorder.episodes, plan.seed, plan.threads)
    report = train_report(training, plan, snapshots, chosen, episodes, run_dir)
    write_text(run_dir / "metrics.csv", metrics_csv(training.trainer.history))
    write_text(run_dir / DRAWN, drawn.csv(training.randomizer.space.names))
    _keep_context(training, run_dir)
    record = replace(_record(training, snapshots, report), episodes=episodes)
    finish(run_dir, report, train_page(report), plan.env, record, recorder)
    return report


def _require_learnt(training: Training, frames: int) -> None:
    """Refuse a run that ends before its policy or its distribution is learned for the first time."""
    first = training.algorithm.first
    if frames < first:
        raise ConfigError(
            f"frames is {frames}, but {training.algorithm.name} learns from control step {first} on, so that the "
            f"policy would stay as it is. Set frames to {first} or more, or lower learning_starts of the algorithm."
        )
    first = max(training.learner.first, training.learner.every)
    if frames < first:
        raise ConfigError(
            f"frames is {frames}, but the distribution is learned from control step {first} on, so that it would stay "
            f"as it is. Set frames to {first} or more, or let distribution_learner begin sooner (every, warm_up)."
        )


def _noted(training: Training, choice: Choice) -> tuple[Snapshots, PolicySnapshots, DrawnContexts]:
    """What is noted while it trains, and kept in its checkpoints: the distribution, policies, and contexts drawn."""
    kept = choice.snapshots if training.algorithm.judged_by_return else 1  # the last, where no return says which
    snapshots, policies = Snapshots(training.randomizer), PolicySnapshots(training.algorithm, kept)
    drawn = DrawnContexts()
    training.experience.listen(drawn.take)
    training.more.update(snapshots=snapshots, policies=policies, drawn=drawn)
    return snapshots, policies, drawn


def _record(training: Training, snapshots: Snapshots, report: TrainReport) -> TrainingRecord:
    """What the recording shows of training itself: no fixed values, and ellipses only of what was learned."""
    marginals = [each for each in snapshots.marginals() if each.learned or report.context[each.name].std]
    return TrainingRecord(
        report.env,
        curves(training.trainer.history),
        marginals,
        snapshots.pairs() if any(each.learned for each in marginals) else [],
        spreads=snapshots.spreads(),
        comparisons=snapshots.comparisons(),
        declines=declines(report.ladder),
    )


def _go_on(training: Training, plan: Plan, resume: str) -> None:
    """Put a training into the state that an interrupted run left."""
    training.trainer.resume(Path(resume).expanduser() / CHECKPOINT)
    played = training.trainer.frames
    if played >= plan.frames:
        Console().print(
            f"{resume} has played {played} control steps, and frames is {plan.frames}: nothing is left to be trained. "
            "Raise frames to go on.",
            markup=False,
            soft_wrap=True,
        )


def _deploy(
    training: Training, policies: PolicySnapshots, choice: Choice, plan: Plan, run_dir: Path
) -> tuple[Policy, ChoiceEntry]:
    """Write the chosen policy down; gives it and what the report says of the choice."""
    found = policies.restored()
    chosen = choice.choose(found, plan.env, training.randomizer, plan.seed, plan.threads)
    save(run_dir / POLICY, policies.taken[chosen.index])
    kept = tuple(SnapshotEntry(at.frames, value) for at, value in zip(found, chosen.returns, strict=True))
    best = found[chosen.index]
    return best.deployed, ChoiceEntry(kept, best.frames, chosen.frames, POLICY)


def _keep_context(training: Training, run_dir: Path) -> None:
    """Write a Gaussian that was learnt as a fitted context, which `from_run` of models and randomizers takes."""
    randomizer = training.randomizer
    if training.learner.learns and isinstance(randomizer, GaussianRandomizer):
        write_context(run_dir / CONTEXT, ContextEstimate(randomizer.space, *randomizer.moments()))


def _run(training: Training, snapshots: Snapshots, policies: PolicySnapshots, plan: Plan, run_dir: Path) -> None:
    trainer = training.trainer
    (run_dir / POLICY).unlink(missing_ok=True)  # of a run that ended here before
    try:
        with closing(trainer), progress(plan.frames, trainer.frames) as show:

            def watch(figures: Mapping[str, float], finished: Finished) -> None:
                stop_if_asked()
                if training.learner.learns:
                    snapshots.take(int(figures["iteration"]), training.learner.compared())
                if trainer.due or trainer.frames >= plan.frames:
                    policies.take(trainer.frames)
                if trainer.due:
                    write_text(run_dir / "metrics.csv", metrics_csv(trainer.history))
                del finished
                show(figures["frames"], _so_far(figures, plan.frames))
                tell(int(figures["iteration"]), figures)

            trainer.run(plan.frames, watch)
    except KeyboardInterrupt:
        if (run_dir / CHECKPOINT).is_file():
            Console().print(f"Interrupted. To go on, add {typed('resume', run_dir)}", markup=False, soft_wrap=True)
        raise


def _so_far(figures: Mapping[str, float], frames: int) -> str:
    """Control steps, and the mean return of the episodes that ended last."""
    value = figures["episode_return"]
    returns = "no episode ended" if np.isnan(value) else f"return {value:.1f}"
    return f"Training, {figures['frames']:.0f} of {frames} control steps, {returns}"
