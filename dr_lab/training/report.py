"""What a training run came to, for its report."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.training import Marginal
from dr_lab.reports.plain import finite
from dr_lab.reports.train import SCHEMA, ChoiceEntry, ContextEntry, HistogramEntry, TrainReport
from dr_lab.training.episodes import described
from dr_lab.training.history import adapted_returns, ended_episodes, final_episodes, final_return, infeasible_episodes
from dr_lab.training.ladder import ladder
from dr_lab.training.plan import CHECKPOINT, Plan, Training
from dr_lab.training.snapshots import Snapshots
from dr_lab.trajectory import Array

_DRAWS = 100_000  # of a distribution, for its mean and standard deviation: to 0.3 % of the latter


def train_report(
    training: Training,
    plan: Plan,
    snapshots: Snapshots,
    choice: ChoiceEntry,
    episodes: Sequence[Episode],
    run_dir: Path,
) -> TrainReport:
    """The report as it is written.

    Args:
        training: at its end.
        plan: what was trained, and on what.
        snapshots: the distribution over time.
        choice: which policy is deployed.
        episodes: of it.
        run_dir: the run folder.
    """
    history, last = training.trainer.history, training.trainer.history[-1]
    adapted = adapted_returns(history, plan.final_share)
    found = TrainReport(
        schema=SCHEMA,
        verb="train",
        env=plan.env.name,
        algorithm=training.algorithm.name,
        iterations=len(history),
        frames=training.trainer.frames,
        seconds=last["seconds"],
        final_return=adapted[-1] if adapted else final_return(history, plan.final_share),
        final=last,
        context=_context(training.randomizer, snapshots.marginals()),
        checkpoint=CHECKPOINT,
        run=str(run_dir),
        rollout_frames=int(last["rollout_frames"]),
        infeasible_episodes=infeasible_episodes(history),
        episodes=described(episodes),
        choice=choice,
        adapted_returns=adapted,
        ladder=ladder(history, snapshots.spreads()),
        final_episodes=None if adapted else final_episodes(history, plan.final_share),
        deployed_return=None if adapted else choice.mean_return,
        ended_episodes=ended_episodes(history),
    )
    return finite(found)


def _context(randomizer: Randomizer, learned: Sequence[Marginal]) -> Mapping[str, ContextEntry]:
    draws = randomizer.sample([np.random.default_rng(0)] * _DRAWS).T
    return {
        p.name: ContextEntry(p.unit, *_moments(column), p.low, p.high, _histogram(marginal))
        for p, column, marginal in zip(randomizer.space.parameters, draws, learned, strict=True)
    }


def _moments(draws: Array) -> tuple[float, float]:
    """Mean and standard deviation, exact where all draws are the same."""
    return (float(draws.mean()), float(draws.std())) if np.ptp(draws) else (float(draws[0]), 0.0)


def _histogram(marginal: Marginal) -> HistogramEntry:
    """The distribution at the end, beside the one at the beginning."""
    return HistogramEntry(
        *(tuple(each.tolist()) for each in (marginal.edges, marginal.initial, marginal.probability[-1]))
    )
