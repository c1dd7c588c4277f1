"""Collecting with TorchRL's collector."""

from collections.abc import Iterator, Mapping
from typing import Any, cast

import torchrl.collectors
from tensordict import TensorDict, TensorDictBase

from dr_lab.collectors.collector import Collector, Policy
from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.trajectory import Array

KEPT = ("observation", "context", "proposal", "action", "next")


class TorchRLCollector(Collector):
    """`torchrl.collectors.Collector` on a policy that does nothing but act: likelihoods follow once a batch.

    Args:
        env: the episodes.
        policy: what acts.
        steps: control steps of each episode slot in a batch.
    """

    def __init__(self, env: BatchedEnv, policy: Policy, steps: int) -> None:
        super().__init__(policy)
        self._env = env
        beginning = env.state_dict()
        self._collector = torchrl.collectors.Collector(
            env,
            Acting(policy),
            frames_per_batch=steps * env.episodes.nsim,
            total_frames=-1,
            track_traj_ids=False,
            trust_policy=True,
        )
        self.load_state_dict(beginning)  # TorchRL tries the environment out
        self._batches = cast(Iterator[TensorDict], iter(self._collector))

    def begin(self, z: Array | None) -> None:
        """Begin new episodes in all slots."""
        self._env.set_contexts(z)
        self._collector._carrier.update(self._env.reset())

    def state_dict(self) -> dict[str, Any]:
        """The episodes."""
        return self._env.state_dict()

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on with the episodes."""
        self._env.load_state_dict(state)
        self._collector._carrier.update(self._env.current())

    def close(self) -> None:
        """Shut TorchRL's collector down."""
        self._collector.shutdown()

    def _collect(self) -> TensorDict:
        return next(self._batches).select(*KEPT)


class Acting:
    """A policy as TorchRL calls it: a tensordict in, its action set.

    Args:
        policy: what acts.
    """

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def __call__(self, tensordict: TensorDictBase) -> TensorDictBase:
        """Set ``action``."""
        return tensordict.set("action", self._policy(tensordict.get("observation")))
