"""What a policy is worth as a beginning: jump-start and asymptote of training on, context by context."""

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dr_lab.bounds import Count, require_bounds
from dr_lab.errors import ConfigError
from dr_lab.evaluators.context_axes import in_groups
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Subject
from dr_lab.evaluators.statistics import interquartile_mean, means_of_contexts
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Curve, Sample
from dr_lab.seeding import derived_seed, stream
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FineTuneEvaluator(Evaluator):
    """Trains on in each of some contexts and follows the return.

    Jump-start is the return before the first step of further training, the asymptote that after the last. An episode
    that diverges counts with the return that the environment declares; a context in which all do, or which does not
    compile, has no return and is counted. Jump-start, asymptote and what is between are means over the same contexts,
    those that have a return in every round: else they would differ by more than the training.

    Source: Mozifian et al. 2020, §V (50 contexts of one parameter, 100 of several, uniformly from p(z)).

    Attributes:
        distribution: makes what contexts are drawn from.
        contexts: drawn.
        rounds: times that the return is measured after training on.
        frames: control steps of training in each round, which ends with a whole batch; a meta-learner takes its own
            updates instead, one a round.
        episodes: whose mean is the return.
        seed: of contexts, starts and training.

    Raises:
        ConfigError: a number is too small.
    """

    distribution: Callable[[ContextSpace], Randomizer]
    contexts: Count
    rounds: Count
    frames: Count
    episodes: Count
    seed: int

    def __post_init__(self) -> None:
        require_bounds(self, "evaluator")

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Train on in every context.

        Raises:
            ConfigError: rounds are so short that one of them trains nothing, nothing tells the contexts apart, or the
                run would be trained on in contexts of its own.
        """
        del folder
        space = subject.setting.space
        if not space.names and self.contexts > 1:
            raise ConfigError(
                f"evaluator=fine_tune would train on in {self.contexts} contexts, which are all the same: "
                f"{subject.setting.name} has no parameters. Give evaluator.contexts=1, or train with some: "
                "env/context=…, as dr-lab train --help lists them."
            )
        drawn = self.distribution(space).sample([stream(self.seed, "fine_tune")] * self.contexts)
        frames, returns = list[list[int]](), list[Array]()
        for index, (group, count) in enumerate(in_groups(drawn, subject.together)):
            taken, returned = self._follow(subject, group, index)
            frames.append(taken)
            returns.append(returned[:count])
            progress(sum(map(len, returns)) / len(drawn))
        courses = np.concatenate(returns)
        at = np.array(frames).max(axis=0)
        return replace(_summed_up(space, drawn, at, courses), told=self._told(int(at[-1])))

    def _told(self, frames: int) -> str:
        return (
            f"Training on in each of {self.contexts} contexts, {self.rounds} rounds of {frames} control "
            "steps together. "
            f"jump start: return before, asymptote: after, of {self.episodes} episodes each; interquartile means "
            "over the contexts that have a return in every round. An episode that diverges counts with the return that "
            "the task declares. infeasible and infeasible after: share of the contexts in which all do, or which do "
            "not compile."
        )

    def _follow(self, subject: Subject, z: Array, index: int) -> tuple[list[int], Array]:
        """Control steps of a context's training, rounds + 1, and returns before and after every round.

        Args:
            subject: what is trained on.
            z: contexts that are adapted to at once, shape (k, n).
            index: number of their group.

        Returns:
            Returns have shape (k, rounds + 1). They are NaN where the context is infeasible; nothing is trained where
            all are so from the start.

        Raises:
            ConfigError: a round trains nothing.
        """
        with closing(subject.adapting(z, self.frames, derived_seed(self.seed, "fine_tune", index))) as adapting:
            rollouts = subject.rollouts(self.episodes * len(z), self.seed, adapting.policy)
            wanted = np.repeat(z, self.episodes, axis=0)

            def measured() -> Array:
                returned, infeasible = rollouts.outcomes(wanted)
                return means_of_contexts(returned.reshape(len(z), -1), infeasible.reshape(len(z), -1))

            frames, returns = [0], [measured()]
            if np.isnan(returns[0]).all():
                return [0] * (self.rounds + 1), np.tile(returns[0][:, None], self.rounds + 1)
            for _ in range(self.rounds):
                adapting.update()
                frames.append(adapting.frames // len(z))
                returns.append(measured())
        return frames, np.stack(returns, axis=1)


def _summed_up(space: ContextSpace, drawn: Array, frames: NDArray[np.int64], returns: Array) -> Evaluation:
    feasible = np.isfinite(returns)
    throughout = feasible.all(axis=1)
    typical = np.array([_typical(column) for column in returns[throughout].T])
    infeasible = np.mean(~feasible, axis=0)
    figures = {
        "jump_start": float(typical[0]),
        "asymptote": float(typical[-1]),
        "infeasible": float(infeasible[0]),
        "infeasible_after": float(infeasible[-1]),
    }
    rows = [
        {**dict(zip(space.names, z.tolist(), strict=True)), "jump_start": float(r[0]), "asymptote": float(r[-1])}
        for z, r in zip(drawn, returns, strict=True)
    ]
    curves = [
        Curve("return while training on", "", frames, typical, over="frames"),
        Curve("infeasible share while training on", "", frames, infeasible, over="frames"),
    ]
    units = {p.name: p.unit for p in space.parameters}
    samples = [Sample("before", returns[:, 0], "A context each."), Sample("after training on", returns[:, -1])]
    return Evaluation(figures, rows, units, curves=curves if throughout.any() else (), samples=samples)


def _typical(returns: Array) -> float:
    """Interquartile mean, NaN of nothing."""
    return float(interquartile_mean(returns)) if len(returns) else np.nan
