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
        return self.advantages(torch.zeros_like(self.reward), gamma, 1.0)

    def advantages(self, baseline: Tensor, gamma: float, lam: float) -> Tensor:
        """Generalised advantages with the baseline as value, shape (k, t); G_t − b_t where λ = 1.

        Args:
            baseline: b, shape (k, t); an episode is worth nothing after its end.
            gamma: discount γ per control step.
            lam: λ.
        """
        value, never = baseline * self.mask, torch.zeros_like(self.mask, dtype=torch.bool)
        after = torch.cat([value[:, 1:], torch.zeros_like(value[:, :1])], 1)
        return advantages(self.reward, value, after, never, never, gamma, lam)

    def double(self) -> "WholeEpisodes":
        """The same in float64."""
        return WholeEpisodes(*(field.double() for field in self))


def whole_episodes(batch: TensorDict, mask: Tensor, actor: GaussianActor) -> WholeEpisodes:
    """The feasible ones of some episodes.

    An episode that ends because its context is infeasible is left out whole: no action led to its end.

    Args: as `every_episode`.
    """
    episodes = every_episode(batch, mask, actor)
    feasible = episodes.mask.any(1)
    return WholeEpisodes(*(field[feasible] for field in episodes))


def every_episode(batch: TensorDict, mask: Tensor, actor: GaussianActor) -> WholeEpisodes:
    """All of some episodes, those in infeasible contexts masked whole, up to the longest one's end.

    Args:
        batch: size [k, t], as a collector or `collectors.play.play` gives it, one episode a row from its first step on.
        mask: the steps of that episode, shape (k, t).
        actor: which took the actions, with the normaliser that it had then.
    """
    steps = slice(int(mask.any(0).sum()))
    reward, infeasible = (cast(Tensor, batch["next", key])[:, steps, 0] for key in ("reward", "infeasible"))
    used = mask[:, steps]
    kept = (used & ~(infeasible & used).any(1, keepdim=True)).float()
    return WholeEpisodes(
        actor.normaliser(cast(Tensor, batch["observation"])[:, steps]),
        actor.unit(cast(Tensor, batch["action"])[:, steps]),
        torch.where(kept > 0, reward.float(), 0.0),
        kept,
    )
