"""Whole episodes as a stochastic policy sees them, to learn from or to measure gradients with."""

from typing import NamedTuple, cast

import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.ppo.gae import advantages
from dr_lab.networks.gaussian_actor import GaussianActor


class WholeEpisodes(NamedTuple):
    """k episodes, t being the length of the longest.

    Attributes:
        observation: normalised, shape (k, t, o).
        action: scaled to ±1, shape (k, t, nu).
        reward: 0 beyond an episode's end, shape (k, t).
        mask: 1 for the steps of an episode, 0 beyond its end, shape (k, t).
    """

    observation: Tensor
    action: Tensor
    reward: Tensor
    mask: Tensor

    def returns_to_go(self, gamma: float) -> Tensor:
        """G_t = Σ_{s ≥ t} γ^(s − t) r_s, shape (k, t).

        The end of an episode is the end of its return, also where the time limit cut it: nothing is bootstrapped.

        Args:
            gamma: discount γ per control step.
        """
        nothing, never = torch.zeros_like(self.reward), torch.zeros_like(self.mask, dtype=torch.bool)
        return advantages(self.reward, nothing, nothing, never, never, gamma, 1.0)

    def double(self) -> "WholeEpisodes":
        """The same in float64."""
        return WholeEpisodes(*(field.double() for field in self))


def whole_episodes(batch: TensorDict, mask: Tensor, actor: GaussianActor) -> WholeEpisodes:
    """The feasible ones of some episodes.

    An episode that ends because its context is infeasible is left out whole: no action led to its end.

    Args:
        batch: size [k, t], as a collector or `collectors.play.play` gives it, one episode a row from its first step on.
        mask: the steps of that episode, shape (k, t).
        actor: which took the actions, with the normaliser that it had then.
    """
    infeasible, reward = (cast(Tensor, batch["next", key]).squeeze(-1) for key in ("infeasible", "reward"))
    feasible = ~(infeasible & mask).any(1)
    kept = mask[feasible].float()
    return WholeEpisodes(
        actor.normaliser(cast(Tensor, batch["observation"])[feasible]),
        actor.unit(cast(Tensor, batch["action"])[feasible]),
        reward[feasible].float() * kept,
        kept,
    )
