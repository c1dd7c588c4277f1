"""Returns of the policies that a run had last, with and without exploration."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.evaluators.evaluator import Evaluation, Progress, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.evaluators.statistics import means_of_contexts
from dr_lab.recorders.training import Sample
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_KINDS = "deterministic", "stochastic"


@dataclass(frozen=True, kw_only=True)
class SnapshotsEvaluator(IntervalEvaluator):
    """Plays every snapshot in contexts that were trained on, deterministic and stochastic, the same ones for all.

    The return of one snapshot is a lottery; that of the last ten says what a training run leads to. A context in which
    all episodes of all snapshots are infeasible, as where it does not compile, is left out. In the others an episode
    that diverges counts with the return that the environment declares.

    Attributes: as `IntervalEvaluator`, its episodes of each snapshot, one in each context, twice.

    Raises:
        ConfigError: a number is out of its range.
    """

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play all.

        Raises:
            DataError: the run has kept none.
        """
        del folder
        snapshots = subject.kept()
        z = subject.contexts(self.episodes, stream(self.seed, "snapshots"))
        played = []
        for place, each in enumerate(snapshots, start=1):
            for policy in (each.deployed, each.exploring):
                played.append(subject.rollouts(self.episodes, self.seed, policy).outcomes(z))
            progress(place / len(snapshots))
        returns, infeasible = (np.stack(each) for each in zip(*played, strict=True))
        known = np.isfinite(means_of_contexts(returns.T, infeasible.T))
        means, diverged = (_over_contexts(each[:, known]) for each in (returns, infeasible))
        rows = [
            {
                "frames": float(each.frames),
                **dict(zip(_KINDS, got.tolist(), strict=True)),
                "diverged": float(lost.mean()),
            }
            for each, got, lost in zip(snapshots, means, diverged, strict=True)
        ]
        figures = {
            key: value for name, got in zip(_KINDS, means.T, strict=True) for key, value in self._over(name, got)
        }
        figures |= {"infeasible": float(np.mean(~known)), "diverged": float(diverged.mean())}
        about = f"Mean over the feasible ones of {self.episodes} contexts, of a kept policy."
        samples = [Sample(name, got, about) for name, got in zip(_KINDS, means.T, strict=True)]
        return Evaluation(
            figures, rows, samples=samples, told=self._told(len(rows), int(np.isfinite(means).all(axis=1).sum()))
        )

    def _over(self, name: str, means: Array) -> list[tuple[str, float]]:
        """Interquartile mean over the snapshots, its interval, and the last."""
        figures = {**self.figures(means), "last": float(means[-1])}
        return [(f"{name}.{key}", value) for key, value in figures.items()]

    def _told(self, count: int, known: int) -> str:
        return (
            f"Each policy that the run kept ({count}) plays {self.episodes} episodes without exploration "
            "(deterministic) and as many with it (stochastic), in contexts that it was trained on. iqm is the "
            f"interquartile mean over the policies, low and high its interval ({self.stated(known)}). Which one is "
            "deployed was chosen on other episodes. infeasible is the share of contexts in which every episode of all "
            "policies diverges, or which do not compile; these count for nothing. An episode that diverges in another "
            "counts with the return that the task declares, and diverged is the share of these."
        )


def _over_contexts(values: Array) -> Array:
    """Means over the contexts of (2 k, contexts) values, by snapshot and kind, shape (k, 2); NaN without any."""
    if not values.shape[1]:
        return np.full((len(values) // 2, 2), np.nan)
    return values.mean(axis=1).reshape(-1, 2)
