"""Whole episodes of a policy in contexts of one's choice."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch

from dr_lab.collectors.collector import Policy
from dr_lab.envs.episodes import Episodes
from dr_lab.trajectory import Array


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
        width = self._episodes.nsim
        loads = [z[first : first + width] for first in range(0, len(z), width)]
        return np.concatenate([self._play(load) for load in loads])

    def state_dict(self) -> dict[str, Any]:
        """The random streams of starts."""
        return self._episodes.state_dict()

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._episodes.load_state_dict(state)

    @torch.no_grad()
    def _play(self, z: Array) -> Array:
        episodes = self._episodes
        spare = np.repeat(z[-1:], episodes.nsim - len(z), axis=0)
        episodes.give_contexts(np.concatenate([z, spare]))
        episodes.begin(np.arange(episodes.nsim))
        returns, going = np.zeros(episodes.nsim), np.ones(episodes.nsim, bool)
        while going[: len(z)].any():
            observation = torch.from_numpy(episodes.observation.astype(np.float32))
            outcome = episodes.step(self._policy(observation).numpy())
            returns[going] += outcome.reward[going]
            returns[going & episodes.simulator.infeasible] = np.nan
            going &= ~outcome.done
        return returns[: len(z)]
