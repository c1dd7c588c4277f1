"""Returns over contexts drawn from distributions: mean, interquartile mean, worst contexts, worst episodes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Count
from dr_lab.evaluators.evaluator import Evaluation, Progress, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.evaluators.statistics import lower_tail, means_of_contexts
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Sample
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_WORST = 0.1  # share that the worst decile is, by its name


@dataclass(frozen=True, kw_only=True)
class ReturnsEvaluator(IntervalEvaluator):
    """Some episodes in each of many contexts, for each of some distributions.

    A context's return is the mean of its episodes, so that the worst tenth of contexts is no matter of luck in one.

    Attributes: as `IntervalEvaluator`, with its episodes in each context, and
        distributions: by name, what makes a distribution over the model's parameters.
        contexts: drawn from each.
        parallel: episodes side by side.

    Raises:
        ConfigError: a number is out of its range.
    """

    distributions: Mapping[str, Callable[[ContextSpace], Randomizer]]
    contexts: Count
    parallel: Count

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Play every distribution's contexts; an infeasible one counts for none of the means, and is counted."""
        del folder
        rollouts, rows, samples = subject.rollouts(self.parallel, self.seed), [], list[Sample]()
        for place, (name, make) in enumerate(self.distributions.items(), start=1):
            z = make(subject.setting.space).sample([stream(self.seed, "returns", name)] * self.contexts)
            returns, infeasible = rollouts.outcomes(np.repeat(z, self.episodes, axis=0))
            rows.append({"contexts": name, **self._summed_up(returns, infeasible)})
            samples.append(
                Sample(name, self._means(returns, infeasible), f"Mean of {self.episodes} episodes a context.")
            )
            progress(place / len(self.distributions))
        shown = ("iqm", "worst_decile", "cvar")
        figures = {f"{row['contexts']}.{key}": float(row[key]) for row in rows for key in shown}
        return Evaluation(
            figures, rows, samples=samples, told=self._told([int(np.isfinite(each.value).sum()) for each in samples])
        )

    def _summed_up(self, returns: Array, infeasible: NDArray[np.bool_]) -> dict[str, float]:
        """Figures of the episodes of one distribution, context by context, shape (contexts · episodes,) each."""
        means = self._means(returns, infeasible)
        known = means[np.isfinite(means)]
        counted = returns.reshape(len(means), -1)[np.isfinite(means)].ravel()
        return {
            **self.figures(means),
            "mean": float(known.mean()) if len(known) else float("nan"),
            "worst_decile": lower_tail(means, _WORST),
            "cvar": lower_tail(counted, _WORST),
            "infeasible": float(np.mean(infeasible)),
        }

    def _means(self, returns: Array, infeasible: NDArray[np.bool_]) -> Array:
        """Return of each context, shape (contexts,); NaN of an infeasible one."""
        shape = (self.contexts, self.episodes)
        return means_of_contexts(returns.reshape(shape), infeasible.reshape(shape))

    def _told(self, known: Sequence[int]) -> str:
        return (
            f"{self.contexts} contexts of each distribution, {self.episodes} episodes in each, whose mean is the "
            f"context's return. iqm: interquartile mean over contexts, low and high: its interval "
            f"({self.stated(*known)}); worst decile: mean of the lowest tenth of contexts; cvar: mean of the lowest "
            "tenth of episodes; infeasible: share of episodes. An episode that diverges counts with the return that "
            "the task declares; a context counts for nothing if all of its episodes do."
        )
