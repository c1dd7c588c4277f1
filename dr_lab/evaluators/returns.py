"""Returns over contexts drawn from distributions: mean, interquartile mean, worst tenth."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.errors import require_numbers
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Subject
from dr_lab.evaluators.statistics import iqm_interval, worst_decile
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.reports.quantity import percent
from dr_lab.seeding import stream


@dataclass(frozen=True)
class ReturnsEvaluator(Evaluator):
    """One episode in each of many contexts, for each of some distributions.

    Attributes:
        distributions: by name, what makes a distribution over the model's parameters.
        contexts: drawn from each.
        parallel: episodes side by side.
        confidence: of the intervals.
        resamples: of the bootstrap.
        seed: of contexts, starts and bootstrap.

    Raises:
        ConfigError: a number is out of its range.
    """

    distributions: Mapping[str, Callable[[ContextSpace], Randomizer]]
    contexts: int
    parallel: int
    confidence: float
    resamples: int
    seed: int

    def __post_init__(self) -> None:
        least = {"contexts": 1, "parallel": 1, "resamples": 1}
        require_numbers(self, "evaluator", positive=("confidence",), least=least, below={"confidence": 1.0})

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play every distribution's contexts; an infeasible one counts for none of the means, and is counted."""
        del folder
        rollouts, rows = subject.rollouts(self.parallel, self.seed), []
        for place, (name, make) in enumerate(self.distributions.items(), start=1):
            z = make(subject.setting.space).sample([stream(self.seed, "returns", name)] * self.contexts)
            returns = rollouts.returns(z)
            found = iqm_interval(returns, self.confidence, self.resamples, self.seed)
            known = returns[np.isfinite(returns)]
            rows.append(
                {
                    "contexts": name,
                    "iqm": found.value,
                    "low": found.low,
                    "high": found.high,
                    "mean": float(known.mean()) if len(known) else float("nan"),
                    "worst_decile": worst_decile(returns),
                    "infeasible": float(np.mean(~np.isfinite(returns))),
                }
            )
            progress(place / len(self.distributions))
        figures = {f"{row['contexts']}.{key}": float(row[key]) for row in rows for key in ("iqm", "worst_decile")}
        return Evaluation(figures, rows, told=self._told())

    def _told(self) -> str:
        return (
            f"{self.contexts} contexts of each distribution, an episode in each. iqm: interquartile mean, low and "
            f"high: its {percent(self.confidence)} interval; worst decile: mean of the lowest tenth; infeasible: share."
        )
