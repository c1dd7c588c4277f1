"""What adapting a policy is worth: returns before and after updates over a grid of contexts, and where they hurt."""

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, cast

import numpy as np
from tensordict import TensorDict

from dr_lab.bounds import Confidence, Count, Natural, at_least, require_bounds
from dr_lab.collectors.play import outcomes, play
from dr_lab.envs.environment import Environment
from dr_lab.evaluators.adapted_returns import AdaptedReturns
from dr_lab.evaluators.context_axes import cells, context_axes, in_groups, within
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Subject
from dr_lab.evaluators.statistics import means_of_contexts
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.training import Ways
from dr_lab.reports.quantity import counted, percent
from dr_lab.seeding import derived_seed, stream
from dr_lab.training.recorded import as_episodes
from dr_lab.trajectory import Array

_IN_3D = 2  # of the shown contexts

_Course = Sequence[Episode]
"""Episodes in one context, before and after updates."""


@dataclass(frozen=True, kw_only=True)
class AdaptationEvaluator(Evaluator):
    """Adapts the policy in every cell of a grid, several times over, and plays it after each number of updates.

    What adapting means is known to the run (`Subject.adapting`): a meta-learner takes its own update, on as many
    episodes as it was trained with, any other algorithm trains on for `frames` control steps. All policies are played
    without exploration, and an adaptation's policies from the same starts before and after its updates. Adaptations of
    a cell are independent, and the interval of what updates add to the return is that over them.

    Source: Mehta 2020 (thesis), §4.1 and §4.6.2; Deleu, Bengio 2018, "The effects of negative adaptation in
    model-agnostic meta-learning".

    Attributes:
        axes: by parameter, [lowest, highest, number of values] in SI units; None takes all parameters, which then
            must be one or two, within their bounds.
        count: values of a parameter where `axes` is None.
        updates: after each of which the return is measured.
        repeats: adaptations of a cell.
        frames: control steps of an update where adapting is training on.
        episodes: of each policy.
        shown: contexts whose ways in the plane are drawn.
        confidence: of the intervals.
        seed: of adaptations and starts.

    Raises:
        ConfigError: a number is out of its range.
    """

    axes: Mapping[str, Sequence[float]] | None
    count: Annotated[int, at_least(2)]
    updates: Count
    repeats: Annotated[int, at_least(2)]
    frames: Count
    episodes: Count
    shown: Natural
    confidence: Confidence
    seed: int

    def __post_init__(self) -> None:
        require_bounds(self, "evaluator")

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Adapt in every cell.

        Raises:
            ConfigError: there are more than two parameters to vary, or none, an update trains nothing, or the run would
                be trained on in contexts of its own.
            UnknownNameError: an axis is no parameter of the model.
        """
        del folder
        space = subject.setting.space
        axes = context_axes(space, self.axes, self.count, 2)
        z = cells(space, axes)
        tasks, shown = np.repeat(z, self.repeats, axis=0), self._shown(len(z))
        returns, courses = list[Array](), list[_Course]()
        for index, (group, count) in enumerate(in_groups(tasks, subject.together)):
            place = index * subject.together
            returned, seen = self._adapt(subject, group, index, [each - place for each in shown])
            returns.append(returned[:count])
            courses += seen
            progress((place + count) / len(tasks))
        of_cells = np.concatenate(returns).reshape(len(z), self.repeats, self.updates + 1)
        found = AdaptedReturns(axes, of_cells, within(space, z), self.confidence).summed_up()
        in_3d = [course[end] for course in courses[:_IN_3D] for end in (0, -1)]
        return replace(found, ways=self._ways(subject.setting, courses), episodes=in_3d, told=self._told(len(z)))

    def _shown(self, count: int) -> list[int]:
        """First adaptations of some cells."""
        chosen = stream(self.seed, "adaptation", "shown").permutation(count)[: self.shown]
        return sorted(int(cell) * self.repeats for cell in chosen)

    def _adapt(self, subject: Subject, z: Array, index: int, shown: Sequence[int]) -> tuple[Array, list[_Course]]:
        """Adapt to a group of contexts.

        Args:
            subject: what is adapted.
            z: contexts, shape (k, n).
            index: number of the group.
            shown: whose courses are wanted, among others.

        Returns:
            Returns (k, updates + 1), NaN where the context is infeasible; nothing is learnt where all are so from the
            start.
        """
        seed, wanted = derived_seed(self.seed, "adaptation", index), np.repeat(z, self.episodes, axis=0)
        slots, rows = subject.slots(len(wanted), seed), [row for row in shown if 0 <= row < len(z)]
        begun, returns, seen = slots.state_dict(), list[Array](), list[list[Episode]]()
        with closing(subject.adapting(z, self.frames, seed)) as adapting:
            for done in range(self.updates + 1):
                if done and not np.isnan(returns[0]).all():
                    adapting.update()
                slots.load_state_dict(begun)
                played = play(slots, adapting.policy, wanted)
                returns.append(_means(played, len(z)))
                if done in self._moments and rows:
                    names = [f"task_{index * subject.together + row + 1}_{_when(done)}" for row in rows]
                    first = [row * self.episodes for row in rows]
                    seen.append(as_episodes(subject.setting, slots, _rows(played, first), z[rows], names))
        return np.stack(returns, axis=1), list(zip(*seen, strict=True))

    @property
    def _moments(self) -> list[int]:
        """Numbers of updates after which episodes are shown."""
        return sorted({0, 1, self.updates})

    def _ways(self, environment: Environment, courses: Sequence[_Course]) -> list[Ways]:
        """Where the shown episodes went, where they were to go to a place in the plane."""
        contexts = [
            environment.space.vector({name: value for name, (value, _) in c[0].context.items()}) for c in courses
        ]
        goals = [goal for goal in map(environment.goal, contexts) if goal is not None]
        if not goals:
            return []
        moments = [[episode.qpos[:, :2] for episode in each] for each in zip(*courses, strict=True)]
        after = zip(self._moments[1:], moments[1:], strict=True)
        return [Ways(_when(done).replace("_", " "), np.array(goals), moments[0], each) for done, each in after]

    def _told(self, contexts: int) -> str:
        return (
            f"{self.repeats} adaptations in each of {contexts} contexts, {counted(self.updates, 'update')} each; every "
            f"policy is played without exploration, {self.episodes} episodes from the same starts before and after. "
            "return after k: mean over contexts after k updates; gain k: what they add; hurts and helps: share of the "
            f"contexts where they take off or add without doubt, by the {percent(self.confidence)} interval over the "
            "adaptations (Student's t), context by context; correlation: between return and gain of one update, over "
            "contexts; inside and outside: of the context's bounds; infeasible: share of contexts without a return. "
            "The table has the gain with its interval."
        )


def _when(updates: int) -> str:
    return f"after_{updates}_update{'s' * (updates > 1)}" if updates else "before"


def _means(played: TensorDict, contexts: int) -> Array:
    """Mean return in each context, of as many episodes in each."""
    returns, infeasible = outcomes(played)
    return means_of_contexts(returns.reshape(contexts, -1), infeasible.reshape(contexts, -1))


def _rows(played: TensorDict, rows: Sequence[int]) -> TensorDict:
    return cast(TensorDict, played[list(rows)])
