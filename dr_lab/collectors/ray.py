"""Collecting on several machines with Ray."""

import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any, cast

import torch
import torchrl.collectors
from hydra.utils import instantiate
from tensordict import TensorDict
from tensordict.nn import TensorDictModule
from torchrl.collectors.distributed import RayCollector as TorchRLRayCollector

from dr_lab.bounds import Count, Positive, require_bounds
from dr_lab.collectors.collector import Collector, PoliciesBySlot, Policy, SeededPolicy
from dr_lab.collectors.shares import joined, shares
from dr_lab.collectors.torchrl import KEPT
from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.errors import ConfigError
from dr_lab.extras import MissingLibraryError
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.ray_cluster import HERE, own_sigterm, prepare, unanswered
from dr_lab.trajectory import Array


class RayCollector(Collector):
    """`torchrl.collectors.distributed.RayCollector`: each worker, on whatever machine, plays a share of the episodes.

    Slots keep their random streams, so that contexts and starts are those of the other collectors. The noise of a
    stochastic policy is drawn on each worker, from a seed that this side's random numbers give anew for every batch: a
    run can be repeated and resumed exactly, and differs from one with another number of workers. p(z) is sent with the
    policy before each batch. Of several policies that share the slots, a worker gets those of its own.

    Args:
        env: the episodes as they begin; they go on at the workers.
        policy: what acts.
        steps: control steps of each episode slot in a batch.
        setting: configuration of the environment. Neither models nor running episodes can be sent, so that every worker
            builds its own.
        workers: that share the episodes; their number divides that of the slots.
        cores: of each worker, for its physics.
        address: of a running Ray cluster, whose machines must have dr_lab; ``local`` starts Ray on this one, whatever
            else of Ray runs or ran here.
        patience: for an answer from that cluster [s].

    Raises:
        ConfigError: the workers cannot share the episodes or the policies equally.
    """

    def __init__(
        self,
        env: BatchedEnv,
        policy: Policy,
        steps: int,
        setting: Mapping[str, Any],
        workers: Count,
        cores: Count,
        address: str,
        patience: Positive,
    ) -> None:
        super().__init__(policy)
        self._env, self._steps, self._setting = env, steps, setting
        self.workers, self.cores, self.address, self.patience = workers, cores, address, patience
        require_bounds(self, "collector", RayCollector)
        if env.episodes.nsim % workers:
            raise ConfigError(
                f"collector.workers is {workers}, which does not divide {env.episodes.nsim} episodes. "
                "Change one of them: collector.workers=… episodes=…"
            )
        if isinstance(policy, PoliciesBySlot):
            policy.policy_of_slot(env.episodes.nsim)
        _dealt(policy, workers)
        self._ray: TorchRLRayCollector | None = None
        self._batches: Iterator[TensorDict] = iter(())

    def begin(self, z: Array | None) -> None:
        """Begin new episodes in all slots, on this side, which the workers then play on."""
        self._env.load_state_dict(self.state_dict())
        self._env.set_contexts(z)
        self._env.reset()
        self.load_state_dict(self._env.state_dict())

    def state_dict(self) -> dict[str, Any]:
        """The episodes, wherever they are."""
        if self._ray is None:
            return self._env.state_dict()
        return joined(self._ray.map_fn("slots"), self._env.episodes.nsim)

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on with the episodes."""
        self._env.load_state_dict(state)
        if self._ray is not None:
            self._deal_out(self._ray)

    def close(self) -> None:
        """End the workers, and Ray where it was started here."""
        if self._ray is not None:
            self._ray.shutdown()
            self._ray = None

    def _collect(self) -> TensorDict:
        ray = self._begin() if self._ray is None else self._ray
        own = self._policy.generator if isinstance(self._policy, SeededPolicy) else None
        seeds = torch.randint(2**62, (self.workers,), generator=own).tolist()
        source = self._env.episodes.source
        policies = _dealt(self._policy, self.workers)
        ray.map_fn("renew", [(policy, source, seed) for policy, seed in zip(policies, seeds, strict=True)])
        with warnings.catch_warnings():
            # The policy has just been sent, together with p(z), which TorchRL's own schemes would not take along.
            warnings.filterwarnings("ignore", "RayCollector iteration started before weight sync")
            batch = next(self._batches)
        return cast(TensorDict, batch.flatten(0, 1)).select(*KEPT)

    def _begin(self) -> TorchRLRayCollector:
        if find_spec("ray") is None:
            further = ", on every machine. On one machine collector=lean is faster and needs nothing."
            raise MissingLibraryError("collector=ray", "ray", further)
        prepare("collector.address", self.address, self.patience)
        try:
            with own_sigterm():
                self._ray = self._workers()
        except (ConnectionError, import_module("ray").exceptions.RayError) as error:
            raise unanswered("collector.address", self.address, error) from error
        self._deal_out(self._ray)
        self._batches = cast(Iterator[TensorDict], iter(self._ray))
        return self._ray

    def _workers(self) -> TorchRLRayCollector:
        episodes = self._env.episodes
        make = partial(_make, self._setting, episodes.nsim // self.workers, self.cores)
        here = {"num_cpus": self.workers * self.cores} if self.address == HERE else {}  # a cluster knows its own
        return TorchRLRayCollector(
            [cast(Callable[[], BatchedEnv], make)] * self.workers,
            TensorDictModule(_dealt(self._policy, self.workers)[0], ["observation"], ["action"]),  # tried out by each
            trust_policy=True,
            frames_per_batch=self._steps * episodes.nsim,
            total_frames=sys.maxsize,
            sync=True,
            collector_class=cast(Any, Worker),  # TorchRL's annotation means something else
            collector_kwargs={"track_traj_ids": False},
            weight_sync_schemes={},
            remote_configs={"num_cpus": self.cores},
            ray_init_config={
                "address": self.address,
                "include_dashboard": False,
                "log_to_driver": False,
                "logging_level": "error",
                **here,
            },
        )

    def _deal_out(self, ray: TorchRLRayCollector) -> None:
        ray.map_fn("go_on", [(each,) for each in shares(self._env.state_dict(), self._env.episodes.nsim, self.workers)])


class Worker(torchrl.collectors.Collector):
    """What Ray runs: TorchRL's collector on a share of the episodes."""

    policy: TensorDictModule

    def slots(self) -> dict[str, Any]:
        """The state of the episodes."""
        return self._played.state_dict()

    def go_on(self, state: Mapping[str, Any]) -> None:
        """Play on from a state of the episodes."""
        self._played.load_state_dict(state)
        self._carrier.update(self._played.current())

    def renew(self, policy: Policy, source: ContextSource | None, seed: int) -> None:
        """Play on with another policy, contexts from another source, and the noise of this seed."""
        self.policy.module = policy
        self._played.episodes.source = source
        if isinstance(policy, SeededPolicy):
            policy.reseed(seed)
        else:
            torch.default_generator.manual_seed(seed)

    @property
    def _played(self) -> BatchedEnv:
        return cast(BatchedEnv, self.env)


def _make(setting: Mapping[str, Any], slots: int, cores: int) -> BatchedEnv:
    torch.set_num_threads(1)  # small networks gain nothing from a second thread; the physics has its own
    return instantiate(setting, _convert_="all").make(None, slots, 0, cores)


def _dealt(policy: Policy, workers: int) -> list[Policy]:
    """What acts at each worker."""
    if isinstance(policy, PoliciesBySlot):
        return [policy.of_worker(worker, workers) for worker in range(workers)]
    return [policy] * workers
