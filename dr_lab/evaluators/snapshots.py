"""Returns of the policies that a run had last, with and without exploration."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.collectors.collector import Policy
from dr_lab.evaluators.evaluator import Evaluation, Progress, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.recorders.training import Sample
from dr_lab.reports.quantity import percent
from dr_lab.seeding import stream
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class SnapshotsEvaluator(IntervalEvaluator):
    """Plays every snapshot in contexts that were trained on, deterministic and stochastic, the same ones for all.

    The return of one snapshot is a lottery; that of the last ten says what a training run leads to.

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
        rows = []
        for place, each in enumerate(snapshots, start=1):
            returns = [self._return(subject, policy, z) for policy in (each.deployed, each.exploring)]
            rows.append({"frames": float(each.frames), "deterministic": returns[0], "stochastic": returns[1]})
            progress(place / len(snapshots))
        figures = {key: value for name in ("deterministic", "stochastic") for key, value in self._over(rows, name)}
        samples = [
            Sample(name, np.array([row[name] for row in rows]), f"Mean of {self.episodes} episodes of a kept policy.")
            for name in ("deterministic", "stochastic")
        ]
        return Evaluation(figures, rows, samples=samples, told=self._told(len(rows)))

    def _return(self, subject: Subject, policy: Policy, z: Array) -> float:
        """Mean of what the policy got."""
        return float(subject.rollouts(self.episodes, self.seed, policy).outcomes(z)[0].mean())

    def _over(self, rows: list[dict[str, float]], name: str) -> list[tuple[str, float]]:
        """Interquartile mean over the snapshots, its interval, and the last."""
        values = np.array([row[name] for row in rows])
        figures = {**self.figures(values), "last": float(values[-1])}
        return [(f"{name}.{key}", value) for key, value in figures.items()]

    def _told(self, count: int) -> str:
        return (
            f"Each policy that the run kept ({count}) plays {self.episodes} episodes without exploration "
            "(deterministic) and as many with it (stochastic), in contexts that it was trained on. iqm is the "
            f"interquartile mean over the policies, low and high its {percent(self.confidence)} interval. Which one is "
            "deployed was chosen on other episodes."
        )
