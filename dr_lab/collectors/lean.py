"""Collecting straight into arrays."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from tensordict import TensorDict

from dr_lab.collectors.collector import Collector, Policy
from dr_lab.envs.batched_env import BatchedEnv, single
from dr_lab.trajectory import Array


class LeanCollector(Collector):
    """Writes every step into arrays of shape (steps, n) that are made once, without a tensordict in between.

    Args:
        env: the episodes.
        policy: what acts.
        steps: control steps of each episode slot in a batch.
    """

    def __init__(self, env: BatchedEnv, policy: Policy, steps: int) -> None:
        super().__init__(policy)
        self._episodes, self._steps = env.episodes, steps
        episodes = self._episodes
        width = {
            "observation": episodes.observation.shape[1],
            "context": episodes.contexts.shape[1],
            "action": len(episodes.low),
        }
        shape = (steps, episodes.nsim)
        self._now: dict[str, np.ndarray] = {k: np.empty((*shape, w), np.float32) for k, w in width.items()}
        self._now["proposal"] = np.empty(shape, np.int64)
        self._next = {
            "observation": np.empty_like(self._now["observation"]),
            "reward": np.empty((*shape, 1), np.float32),
        }
        self._next |= {key: np.empty((*shape, 1), bool) for key in ("done", "terminated", "truncated", "infeasible")}

    def begin(self, z: Array | None) -> None:
        """Begin new episodes in all slots."""
        self._episodes.give_contexts(z)
        self._episodes.begin(np.arange(self._episodes.nsim))

    def state_dict(self) -> dict[str, Any]:
        """The episodes."""
        return self._episodes.state_dict()

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on with the episodes."""
        self._episodes.load_state_dict(state)

    def _collect(self) -> TensorDict:
        for t in range(self._steps):
            self._step(t)
        shape = (self._episodes.nsim, self._steps)
        now, then = (
            {
                key: torch.from_numpy(array).transpose(0, 1).clone(memory_format=torch.contiguous_format)
                for key, array in arrays.items()
            }
            for arrays in (self._now, self._next)
        )
        then["context"], then["proposal"] = now["context"], now["proposal"]  # an episode keeps its context
        return TensorDict({**now, "next": TensorDict(then, batch_size=shape)}, batch_size=shape)

    def _step(self, t: int) -> None:
        episodes, now, then = self._episodes, self._now, self._next
        observation = single(episodes.observation)
        now["observation"][t], now["context"][t] = observation.numpy(), episodes.contexts
        now["proposal"][t] = episodes.proposals
        now["action"][t] = self._policy(observation).numpy()
        outcome = episodes.step(now["action"][t])
        then["observation"][t] = outcome.observation
        then["reward"][t, :, 0] = outcome.reward
        then["terminated"][t, :, 0], then["truncated"][t, :, 0] = outcome.terminated, outcome.truncated
        then["infeasible"][t, :, 0] = outcome.infeasible
        then["done"][t, :, 0] = done = outcome.done
        if done.any():
            episodes.begin(np.flatnonzero(done))
