"""Whole episodes of a policy in contexts of one's choice."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from dr_lab.collectors.collector import Policy
from dr_lab.envs.episodes import Episodes, Flags, StepOutcome
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Step:
    """One control step of all slots.

    Attributes:
        going: slots whose episode had not ended before, shape (n,).
        action: as the policy gave it, shape (n, nu).
        outcome: what it led to.
    """

    going: Flags
    action: Array
    outcome: StepOutcome


def begin(episodes: Episodes, z: Array) -> None:
    """Begin an episode in each context (k, n), k being at most the number of slots; the other slots repeat the last."""
    spare = np.repeat(z[-1:], episodes.nsim - len(z), axis=0)
    episodes.give_contexts(np.concatenate([z, spare]))
    episodes.begin(np.arange(episodes.nsim))


def play(episodes: Episodes, policy: Policy, count: int) -> Iterator[Step]:
    """Play what was begun, step by step, until the episodes of the first `count` slots have ended.

    Slots whose episode has ended are stepped along with the others; what happens to them means nothing.
    """
    going = np.ones(episodes.nsim, bool)
    while going[:count].any():
        with torch.no_grad():
            action = policy(torch.from_numpy(episodes.observation.astype(np.float32))).numpy()
        outcome = episodes.step(action)
        yield Step(going, action, outcome)
        going = going & ~outcome.done


class PolicyRollouts:
    """Plays a policy, as it is then, on episodes that are kept for this purpose.

    Args:
        episodes: slots that run side by side; more contexts than slots are played one load after the other.
        policy: what acts.
    """

    def __init__(self, episodes: Episodes, policy: Policy) -> None:
        self._episodes = episodes
        self._policy = policy

    def returns(self, z: Array) -> Array:
        """Undiscounted return of an episode in each context (k, n), shape (k,); NaN where the context is infeasible."""
        returns, infeasible = self.outcomes(z)
        return np.where(infeasible, np.nan, returns)

    def outcomes(self, z: Array) -> tuple[Array, Flags]:
        """Undiscounted return of an episode in each context (k, n), and whether it is infeasible, shape (k,) each.

        The return of an infeasible one is what the environment declares.
        """
        width = self._episodes.nsim
        loads = [z[first : first + width] for first in range(0, len(z), width)]
        returns, infeasible = zip(*(self._play(load) for load in loads), strict=True)
        return np.concatenate(returns), np.concatenate(infeasible)

    def state_dict(self) -> dict[str, Any]:
        """The random streams of starts."""
        return self._episodes.state_dict()

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._episodes.load_state_dict(state)

    def _play(self, z: Array) -> tuple[Array, Flags]:
        returns, infeasible = np.zeros(self._episodes.nsim), np.zeros(self._episodes.nsim, bool)
        begin(self._episodes, z)
        for step in play(self._episodes, self._policy, len(z)):
            returns[step.going] += step.outcome.reward[step.going]
            infeasible |= step.going & step.outcome.infeasible
        return returns[: len(z)], infeasible[: len(z)]
