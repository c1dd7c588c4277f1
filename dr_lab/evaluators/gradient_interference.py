"""Whether learning in one context helps or harms the policy in another: cosines of policy gradients."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.score_function import episode_gradients
from dr_lab.bounds import Count, at_least, at_most
from dr_lab.envs.slots import EpisodeSlots
from dr_lab.evaluators.context_axes import cells, context_axes
from dr_lab.evaluators.cosines import Cosines, cosines
from dr_lab.evaluators.evaluator import Evaluation, Progress, Row, Subject
from dr_lab.evaluators.interval_evaluator import IntervalEvaluator
from dr_lab.evaluators.policy_gradients import played, require_gaussian, spread_over
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.recorders.training import ContextAxis, Matrix
from dr_lab.reports.quantity import percent
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class GradientInterferenceEvaluator(IntervalEvaluator):
    """Cosine ρ_ab = ⟨∇J_a, ∇J_b⟩/(‖∇J_a‖‖∇J_b‖) between every two contexts along one parameter, as training went on.

    Below 0 a step that improves the policy in a makes it worse in b (interference), above 0 better (transfer).
    Gradients are score-function estimates of the exploring policy, by all of its parameters. `Cosines` says what is
    made of their noise.

    Source: Mehta 2020 (thesis), equation 1.2.1 and figures 3.3 to 3.7, which have ḡ in place of ∇J.

    Attributes: as `IntervalEvaluator`, its episodes in each context, and
        axes: the parameter with [lowest, highest, number of values] in SI units; None takes the model's, which then
            must be one, within its bounds.
        count: contexts where `axes` is None.
        snapshots: policies at most, of those that the run kept, at equal distances.
        parallel: episodes side by side.
        baseline: what is taken off the returns-to-go.
        gamma: discount per control step.

    Raises:
        ConfigError: a number is out of its range.
    """

    axes: Mapping[str, Sequence[float]] | None
    count: Annotated[int, at_least(2)]
    snapshots: Count
    episodes: Annotated[int, at_least(4)]
    parallel: Count
    baseline: Baseline
    gamma: Annotated[float, at_least(0.0), at_most(1.0)]

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Compare the contexts for each snapshot.

        Raises:
            ConfigError: the policy is not Gaussian, or not just one parameter is to be varied.
            DataError: the run has kept no policy.
        """
        del folder
        space = subject.setting.space
        (axis,) = context_axes(space, self.axes, self.count, 1)
        z, slots = cells(space, [axis]), subject.slots(self.parallel, self.seed)
        chosen = spread_over(subject.kept(), self.snapshots)
        found = dict[int, Cosines]()
        for number, snapshot in enumerate(chosen):
            actor = require_gaussian(snapshot.exploring, "gradient_interference")
            actor.reseed(self.seed)
            gradients = list[Array]()
            for place, row in enumerate(z, start=1):
                gradients.append(self._gradients(slots, actor, row))
                progress((number + place / len(z)) / len(chosen))
            found[snapshot.frames] = cosines(gradients, self.confidence, self.resamples, self.seed)
        return self._evaluation(axis, found)

    def _gradients(self, slots: EpisodeSlots, actor: GaussianActor, z: Array) -> Array:
        """Of each episode in one context, shape (k, p); k is smaller where some are infeasible."""
        course = played(slots, actor, np.tile(z, (self.episodes, 1)), self.baseline, self.gamma)
        if not len(course.advantage):
            return np.empty((0, sum(each.numel() for each in actor.parameters())))
        return episode_gradients(actor, course.episodes, course.advantage).numpy()

    def _evaluation(self, axis: ContextAxis, found: Mapping[int, Cosines]) -> Evaluation:
        newest = sorted(found, reverse=True)  # figures are of the last policy, and a page has room for its first rows
        rows = [row for frames in newest for row in _rows(frames, axis, found[frames])]
        return Evaluation(
            _shares(found[max(found)]),
            rows,
            {f"{axis.name} {side}": axis.unit for side in "ab"},
            matrices=_pictures(axis, found),
            told=self._told(len(axis.values)),
        )

    def _told(self, contexts: int) -> str:
        return (
            f"Policy gradients from {self.episodes} episodes with exploration in each of {contexts} contexts. cosine: "
            "between the mean gradients of two contexts, which noise draws to 0; of a context with itself it is the "
            "cosine that as many other episodes would have, so that a cell is to be compared with the diagonal of its "
            f"row and column. corrected: without the noise, with its {percent(self.confidence)} interval by bootstrap "
            "over the episodes; by what noise is left it may lie beyond ±1, and nothing stands where a gradient is not "
            "told from noise. sign: −1 where the two contexts "
            "interfere, 1 where one helps the other, 0 where the interval holds 0, which is a dot in the picture; "
            "nothing where a context has no gradient. "
            "Figures are those of the last policy and of contexts with a gradient, which infeasible ones lack: the "
            "shares of their pairs that interfere, help or are in doubt, and of those told from noise."
        )


def _rows(frames: int, axis: ContextAxis, found: Cosines) -> list[Row]:
    return [
        {
            "frames": float(frames),
            f"{axis.name} a": float(axis.values[a]),
            f"{axis.name} b": float(axis.values[b]),
            "cosine": float(found.raw[a, b]),
            "corrected": float(found.corrected[a, b]),
            "low": float(found.low[a, b]),
            "high": float(found.high[a, b]),
            "sign": float(found.sign[a, b]) if np.isfinite(found.raw[a, b]) else np.nan,
        }
        for a, b in zip(*np.triu_indices(len(axis.values)), strict=True)
    ]


def _shares(found: Cosines) -> dict[str, float]:
    """Of the contexts that have a gradient, which infeasible ones lack, and of their pairs; NaN where there is none."""
    half = np.triu_indices(len(found.sign), 1)
    pairs = found.sign[half][np.isfinite(found.raw[half])]
    alone = np.diagonal(found.corrected)[np.isfinite(np.diagonal(found.raw))]
    return {
        "share_interfering": _share(pairs < 0),
        "share_helping": _share(pairs > 0),
        "share_in_doubt": _share(pairs == 0),
        "share_told_from_noise": _share(np.isfinite(alone)),
    }


def _share(told: NDArray[np.bool_]) -> float:
    return float(told.mean()) if len(told) else np.nan


def _pictures(axis: ContextAxis, found: Mapping[int, Cosines]) -> list[Matrix]:
    """The last policy first; what is known of no two contexts has none."""
    newest = sorted(found, reverse=True)
    return [
        Matrix(f"{name} after {frames} control steps", axis, value, found[frames].sign == 0)
        for frames in newest
        for name, value in (("cosine", found[frames].raw), ("cosine without noise", found[frames].corrected))
        if np.isfinite(value).any()
    ]
