"""What a policy is worth as a beginning: jump-start and asymptote of training on, context by context."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dr_lab.errors import require_numbers
from dr_lab.evaluators.evaluator import Evaluation, Evaluator, Progress, Subject
from dr_lab.evaluators.statistics import interquartile_mean
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Curve
from dr_lab.seeding import stream
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class FineTuneEvaluator(Evaluator):
    """Trains on in each of some contexts and follows the return.

    Jump-start is the return before the first step of further training, the asymptote that after the last. Infeasible
    contexts are counted and left out.

    Source: Mozifian et al. 2020, §V (50 contexts of one parameter, 100 of several, uniformly from p(z)).

    Attributes:
        distribution: makes what contexts are drawn from.
        contexts: drawn.
        rounds: times that the return is measured after training on.
        frames: control steps of training in each round.
        episodes: whose mean is the return.
        seed: of contexts, starts and training.

    Raises:
        ConfigError: a number is too small.
    """

    distribution: Callable[[ContextSpace], Randomizer]
    contexts: int
    rounds: int
    frames: int
    episodes: int
    seed: int

    def __post_init__(self) -> None:
        require_numbers(self, "evaluator", least={"contexts": 1, "rounds": 1, "frames": 1, "episodes": 1})

    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Train on in every context."""
        space = subject.setting.space
        drawn = self.distribution(space).sample([stream(self.seed, "fine_tune")] * self.contexts)
        followed = []
        for index, z in enumerate(drawn):
            followed.append(self._follow(subject, z, index, folder / f"fine_tune_{index}.pt"))
            progress((index + 1) / len(drawn))
        returns = np.array(followed)
        return _summed_up(space, drawn, returns, self.frames)

    def _follow(self, subject: Subject, z: Array, index: int, checkpoint: Path) -> Array:
        """Return before and after every round, shape (rounds + 1,); NaN where the context is infeasible."""
        space = subject.setting.space
        trainer, policy = subject.again(
            FixedRandomizer(space, dict(zip(space.names, z.tolist(), strict=True))), self.seed + index, checkpoint
        )
        rollouts = subject.rollouts(self.episodes, self.seed, policy)
        wanted, begun = np.repeat(z[None], self.episodes, axis=0), trainer.frames
        returns = [rollouts.returns(wanted).mean()]
        for done in range(1, self.rounds + 1):
            if not np.isfinite(returns[0]):
                return np.full(self.rounds + 1, np.nan)
            trainer.run(begun + done * self.frames, lambda *_: None)
            returns.append(rollouts.returns(wanted).mean())
        return np.array(returns)


def _summed_up(space: ContextSpace, drawn: Array, returns: Array, frames: int) -> Evaluation:
    feasible = np.isfinite(returns[:, 0])
    typical = interquartile_mean(returns[feasible], axis=0) if feasible.any() else np.full(returns.shape[1], np.nan)
    figures = {
        "jump_start": float(typical[0]),
        "asymptote": float(typical[-1]),
        "infeasible": float(np.mean(~feasible)),
    }
    rows = [
        {**dict(zip(space.names, z.tolist(), strict=True)), "jump_start": float(r[0]), "asymptote": float(r[-1])}
        for z, r in zip(drawn, returns, strict=True)
    ]
    curve = Curve("return while training on", "", frames * np.arange(returns.shape[1]), typical)
    return Evaluation(figures, rows, curves=[curve])
