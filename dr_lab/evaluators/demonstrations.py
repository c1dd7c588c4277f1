"""Episodes of a policy in one context, kept for others to imitate."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.evaluators.evaluator import Evaluation, Progress, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.recorders.training import Sample
from dr_lab.training.recorded import record


@dataclass(frozen=True, kw_only=True)
class DemonstrationsEvaluator(IntervalEvaluator):
    """Plays the policy in one context; ``episodes.mcap`` holds all episodes, as ``expert=mcap`` reads them.

    Attributes: as `IntervalEvaluator`, its episodes in the context, and
        context: SI value by parameter; those not named are nominal, as all are with None.

    Raises:
        ConfigError: a number is out of its range.
    """

    context: Mapping[str, float] | None

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play and keep all.

        Raises:
            UnknownNameError: a name is not a parameter.
        """
        del folder
        setting = subject.setting
        z = np.tile(setting.space.vector(self.context or {}), (self.episodes, 1))
        played = record(setting, subject.slots(self.episodes, self.seed), subject.policy, z)
        progress(1.0)
        rows = [
            {"episode": each.name, "return": each.undiscounted, "steps": float(len(each.reward)), "ended": each.ended}
            for each in played
        ]
        returns = np.array([each.undiscounted for each in played])
        samples = [Sample("episodes", returns, "An episode each.")]
        return Evaluation(self.figures(returns), rows, samples=samples, episodes=played, told=self._told(len(returns)))

    def _told(self, count: int) -> str:
        where = ", ".join(f"{name} = {value:g}" for name, value in (self.context or {}).items()) or "nominal values"
        return (
            f"{self.episodes} episodes in the context {where}. iqm: interquartile mean of their returns, low and high: "
            f"its interval ({self.stated(count)}). episodes.mcap holds what was seen and done, for expert=mcap."
        )
