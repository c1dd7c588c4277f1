"""EPOpt: learn from the episodes that went worst."""

from collections.abc import Mapping
from math import ceil
from typing import Any

import torch
from torch import Tensor

from dr_lab.algorithms.ppo.selection import Selection
from dr_lab.errors import ConfigError


class WorstEpisodes(Selection):
    """Keeps the share ε of episodes with the lowest discounted return: a policy for the worst contexts.

    An episode that goes on beyond the batch counts with what it earned so far, earlier batches included, and with the
    value of where it is; so batches need not hold whole episodes. An episode whose context turns out infeasible is none
    of them: its return is declared, below all others, and there is nothing to be learnt from it.

    Source: Rajeswaran et al. 2017 (EPOpt), algorithm 1, which collects whole episodes instead.

    Args:
        gamma: discount per control step.
        epsilon: ε in (0, 1]; 1 keeps all that are feasible.
        warm_up: first batches of which all feasible episodes are kept, so that there is something to lose.

    Raises:
        ConfigError: a number is out of its range.
    """

    algorithm = "EPOpt"

    def __init__(self, gamma: float, epsilon: float, warm_up: int) -> None:
        super().__init__(gamma)
        if not 0.0 < epsilon <= 1.0 or warm_up < 0:
            raise ConfigError(
                f"algorithm.selection has epsilon {epsilon:g} and warm_up {warm_up}; expected a share in (0, 1] and "
                "a number of batches of at least 0."
            )
        self.epsilon, self.warm_up = epsilon, warm_up
        self._batches = 0
        self.forget_episodes()

    def __call__(self, reward: Tensor, done: Tensor, infeasible: Tensor, next_value: Tensor) -> Tensor:
        """The steps of the worst feasible episodes, shape (n, steps)."""
        returns, last = self._returns(reward, done, infeasible, next_value)
        self._batches += 1
        feasible = returns.isfinite()
        if self._batches <= self.warm_up or not feasible.any():
            return feasible
        each = returns[last & feasible].sort().values
        return returns <= each[ceil(self.epsilon * len(each)) - 1]

    def _returns(self, reward: Tensor, done: Tensor, infeasible: Tensor, next_value: Tensor) -> tuple[Tensor, Tensor]:
        """At every step the return of its whole episode, ∞ where infeasible, and which are an episode's last here."""
        n, steps = reward.shape
        earned, discount = self._earned.expand(n).clone(), self._discount.expand(n).clone()
        returns = torch.empty_like(reward)
        for t in range(steps):
            earned += discount * reward[:, t]
            discount *= self.gamma
            returns[:, t] = earned
            earned[done[:, t]], discount[done[:, t]] = 0.0, 1.0
        self._earned, self._discount = earned, discount
        last = done.clone()
        last[:, -1] = True
        returns[:, -1] += torch.where(done[:, -1], 0.0, discount * next_value[:, -1])
        returns[infeasible] = torch.inf
        for t in reversed(range(steps - 1)):
            returns[:, t] = torch.where(done[:, t], returns[:, t], returns[:, t + 1])
        return returns, last

    def begin_schedules(self) -> None:
        """Warm up again."""
        self._batches = 0

    def forget_episodes(self) -> None:
        """New episodes have earned nothing yet."""
        self._earned, self._discount = torch.zeros(1), torch.ones(1)

    def state_dict(self) -> dict[str, Any]:
        """What is known of the episodes that go on."""
        return {"batches": self._batches, "earned": self._earned, "discount": self._discount}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._batches, self._earned, self._discount = state["batches"], state["earned"], state["discount"]
