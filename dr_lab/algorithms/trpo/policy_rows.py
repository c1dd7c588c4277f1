"""Control steps as policy gradients see them: who acted, and how much better than expected it went."""

from typing import NamedTuple

import torch
from torch import Tensor

from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.networks.gaussian import Gaussian, divergence

_LEAST_STD = 1e-8  # of advantages that are all the same, as in pytorch-maml-rl


class PolicyRows(NamedTuple):
    """R control steps; of T tasks with a leading dimension each.

    Attributes:
        observation: normalised, shape (R, o).
        action: scaled to ±1, shape (R, nu).
        mean: μ of the policy that acted, shape (R, nu).
        log_std: log σ of it, shape (1, nu).
        advantage: A, standardised over the rows that count, shape (R,).
        weight: share of a row in all means, shape (R,), which sum to 1; 0 beyond an episode's end.
    """

    observation: Tensor
    action: Tensor
    mean: Tensor
    log_std: Tensor
    advantage: Tensor
    weight: Tensor

    @property
    def acted(self) -> Gaussian:
        """The policy that acted."""
        return Gaussian(self.mean, self.log_std)

    def thinned(self, every: int) -> "PolicyRows":
        """The first, and each that follows it by so many; what weighs still sums to 1."""
        weight = self.weight[..., ::every]
        return PolicyRows(
            self.observation[..., ::every, :],
            self.action[..., ::every, :],
            self.mean[..., ::every, :],
            self.log_std,
            self.advantage[..., ::every],
            weight / weight.sum(-1, keepdim=True).clamp(min=_LEAST_STD),  # 0 where nothing counts
        )


def policy_rows(episodes: WholeEpisodes, acted: Gaussian, advantage: Tensor) -> PolicyRows:
    """The steps of some episodes (…, k, t) as rows (…, k·t).

    Args:
        episodes: where nothing counts, weights and advantages are 0.
        acted: what acted in them, μ of shape (…, k·t, nu).
        advantage: of every step, shape (…, k, t).
    """
    mask, raw = episodes.mask.flatten(-2), advantage.flatten(-2)
    weight = mask / mask.sum(-1, keepdim=True).clamp(min=1.0)
    centred = (raw - (weight * raw).sum(-1, keepdim=True)) * mask
    std = (weight * centred**2).sum(-1, keepdim=True).sqrt()
    return PolicyRows(
        episodes.observation.flatten(-3, -2),
        episodes.action.flatten(-3, -2),
        acted.mean,
        acted.log_std,
        centred / (std + _LEAST_STD),
        weight,
    )


def ratio(policy: Gaussian, rows: PolicyRows) -> Tensor:
    """ρ = π(u|o)/π_acted(u|o), shape (…, R)."""
    return (policy.log_prob(rows.action) - rows.acted.log_prob(rows.action)).exp()


def mean(values: Tensor, rows: PolicyRows) -> Tensor:
    """Mean of values (…, R) over the rows that count, and over tasks."""
    return torch.sum(values * rows.weight, -1).mean()


def mean_divergence(policy: Gaussian, rows: PolicyRows) -> Tensor:
    """E[KL(π_acted‖π)], exact at every observation, and averaged over these."""
    return mean(divergence(rows.acted, policy), rows)
