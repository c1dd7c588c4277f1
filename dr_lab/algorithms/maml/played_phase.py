"""What was played in some tasks after as many updates as policies had had then."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.algorithms.trpo.policy_rows import PolicyRows


@dataclass(frozen=True)
class PlayedPhase:
    """One episode in every slot, k of T tasks each.

    Attributes:
        rows: their steps, of T tasks.
        episodes: the same as episodes, with a leading dimension of T.
        to_go: discounted returns-to-go, shape (T, k, t).
        observation: of all steps, as the environment gave them, shape (n, o).
    """

    rows: PolicyRows
    episodes: WholeEpisodes
    to_go: Tensor
    observation: Tensor

    @property
    def returns(self) -> Tensor:
        """Mean undiscounted return in each task, shape (T,); NaN where no episode was feasible."""
        feasible = self.episodes.mask.any(-1)
        return (self.episodes.reward.sum(-1) * feasible).sum(-1) / feasible.sum(-1)


def figures_of(returns: Sequence[Tensor]) -> dict[str, float]:
    """Mean return after 0, 1, … updates, what the updates gained, and in which share of tasks they cost some.

    Args:
        returns: mean return in each task after each number of updates, shape (T,).
    """
    known = torch.stack(list(returns)).isfinite().all(0)
    if not known.any():
        return {"tasks_learnt": 0.0}
    means = [each[known] for each in returns]
    gain = means[-1] - means[0]
    found = {f"return_after_{k}": each.mean().item() for k, each in enumerate(means)}
    return {
        "tasks_learnt": float(known.sum()),
        **found,
        "gain": gain.mean().item(),
        "negative_adaptation": (gain < 0).float().mean().item(),
    }
