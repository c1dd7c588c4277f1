"""Rewards in units of the spread of their discounted sums, so that the value network learns numbers around 1."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor

from dr_lab.bounds import Limit, require_bounds


class RewardScale(ABC):
    """What a learner sees of rewards; what is recorded and evaluated is never scaled."""

    @abstractmethod
    def __call__(self, reward: Tensor, done: Tensor, infeasible: Tensor) -> Tensor:
        """Scaled rewards of a batch (n, steps), which the statistics take in first.

        Args:
            reward: shape (n, steps), as all that follows.
            done: whether the episode ended.
            infeasible: whether it ended because its context is infeasible; such rewards teach nothing.
        """

    @property
    @abstractmethod
    def unit(self) -> float:
        """What a scaled reward of 1 was before, where it was not cut."""

    def forget_episodes(self) -> None:  # noqa: B027 (raw rewards have no past)
        """New episodes begin: what those that go on have earned so far is let go, the statistics are kept."""

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """The statistics."""

    @abstractmethod
    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""


class RawRewards(RewardScale):
    """Rewards as they are.

    Args:
        gamma: of nothing; every scale is made alike.
    """

    def __init__(self, gamma: float) -> None:
        del gamma

    def __call__(self, reward: Tensor, done: Tensor, infeasible: Tensor) -> Tensor:
        """The rewards themselves."""
        del done, infeasible
        return reward

    @property
    def unit(self) -> float:
        """1."""
        return 1.0

    def state_dict(self) -> dict[str, Any]:
        """Nothing."""
        return {}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Nothing."""


class RunningRewardScale(RewardScale):
    """r/std(G), G_t = γ G_{t−1} + r_t within an episode, over everything seen so far; cut at ±clip.

    Args:
        gamma: γ.
        clip: largest absolute value.

    Raises:
        ConfigError: it is not above 0.
    """

    def __init__(self, gamma: float, clip: Limit) -> None:
        self._gamma, self.clip = gamma, clip
        require_bounds(self, "algorithm.reward_scale", RunningRewardScale)
        self.forget_episodes()
        self._count, self._mean, self._square = 0.0, 0.0, 0.0

    def __call__(self, reward: Tensor, done: Tensor, infeasible: Tensor) -> Tensor:
        """Scaled rewards of a batch (n, steps)."""
        sums, running = torch.empty_like(reward), self._sum.to(reward.device).expand(len(reward))
        going = (~done).to(reward.dtype)
        for t in range(reward.shape[1]):
            sums[:, t] = self._gamma * running + reward[:, t]
            running = sums[:, t] * going[:, t]
        self._sum = running.clone()
        self._take(sums[~infeasible].double())
        return (reward / self.unit).clamp_(-self.clip, self.clip)

    @property
    def unit(self) -> float:
        """std(G)."""
        return max(self._square - self._mean**2, 0.0) ** 0.5 + 1e-8  # 1e-8: rewards that never change

    def forget_episodes(self) -> None:
        """Sums of new episodes."""
        self._sum = torch.zeros(1)

    def _take(self, sums: Tensor) -> None:
        if not sums.numel():
            return
        self._count += sums.numel()
        share = sums.numel() / self._count
        self._mean += share * (sums.mean().item() - self._mean)
        self._square += share * (sums.square().mean().item() - self._square)

    def state_dict(self) -> dict[str, Any]:
        """The statistics."""
        return {"sum": self._sum, "count": self._count, "mean": self._mean, "square": self._square}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._sum, self._count = state["sum"], state["count"]
        self._mean, self._square = state["mean"], state["square"]
