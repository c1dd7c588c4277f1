"""What evaluators have in common that state an interval with what a few returns say."""

from dataclasses import dataclass

import numpy as np

from dr_lab.bounds import Confidence, Count, require_bounds
from dr_lab.evaluators.evaluator import Evaluator
from dr_lab.evaluators.statistics import Interval, iqm_interval
from dr_lab.reports.interval_level import FEWEST, level
from dr_lab.reports.quantity import percent
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class IntervalEvaluator(Evaluator):
    """An evaluator that plays a number of episodes and bootstraps what they return.

    Attributes:
        episodes: of each policy, target or context, as the evaluator says.
        confidence: of the intervals.
        resamples: of the bootstrap.
        seed: of contexts, starts and bootstrap.

    Raises:
        ConfigError: a number is out of its range.
    """

    episodes: Count
    confidence: Confidence
    resamples: Count
    seed: int

    def __post_init__(self) -> None:
        require_bounds(self, "evaluator")

    def figures(self, values: Array) -> dict[str, float]:
        """Interquartile mean ``iqm`` of values (n,) with the ends ``low`` and ``high`` of its interval."""
        found = self.interval(values)
        return {"iqm": found.value, "low": found.low, "high": found.high}

    def interval(self, values: Array) -> Interval:
        """Interquartile mean of values (n,), those that are known, with its interval."""
        return iqm_interval(np.asarray(values), self.confidence, self.resamples, self.seed)

    def stated(self, *counts: int) -> str:
        """The level of intervals over so many known values each, as a text tells it: what the fewest values carry.

        Those of fewer than three values have no interval of which anything could be said.
        """
        least = min((count for count in counts if count >= FEWEST), default=None)
        if least is None or level(self.confidence, least) == self.confidence:
            return percent(self.confidence)
        return f"{percent(level(self.confidence, least))} at most, of {least} values"
