"""Episodes of a policy in one context, kept for others to imitate."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.errors import DataError
from dr_lab.evaluators.evaluator import Evaluation, Progress, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.recorders.training import Sample
from dr_lab.training.recorded import record


@dataclass(frozen=True, kw_only=True)
class DemonstrationsEvaluator(IntervalEvaluator):
    """Plays the policy in one context; ``episodes.mcap`` holds the episodes, as ``expert=mcap`` reads them.

    Episodes that diverge are left out: what they do is no example. Nothing moves in a context that does not compile.

    Attributes: as `IntervalEvaluator`, its episodes in the context, and
        context: SI value by parameter; those not named are nominal, as all are with None.

    Raises:
        ConfigError: a number is out of its range.
    """

    context: Mapping[str, float] | None

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play, and keep what is feasible.

        Raises:
            UnknownNameError: a name is not a parameter.
            DataError: every episode is infeasible.
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
        kept = [each for each in played if each.ended != "infeasible"]
        if not kept:
            raise DataError(
                f"All {self.episodes} episodes of run {subject.name} in the context {self._where} are infeasible: it "
                "does not compile, or every episode diverges. There is nothing to imitate. Give another "
                "evaluator.context, {parameter: value, …} in SI units."
            )
        returns = np.array([each.undiscounted for each in kept])
        figures = {**self.figures(returns), "infeasible": 1.0 - len(kept) / len(played)}
        samples = [Sample("episodes", returns, "An episode each.")]
        return Evaluation(figures, rows, samples=samples, episodes=kept, told=self._told(len(kept)))

    @property
    def _where(self) -> str:
        return ", ".join(f"{name} = {value:g}" for name, value in (self.context or {}).items()) or "of nominal values"

    def _told(self, kept: int) -> str:
        return (
            f"{self.episodes} episodes in the context {self._where}. {kept} are kept; those that diverge are left out, "
            "of all figures, too, and infeasible is their share. iqm: interquartile mean of the returns, low and high: "
            f"its interval ({self.stated(kept)}). episodes.mcap holds what was seen and done, for expert=mcap."
        )
