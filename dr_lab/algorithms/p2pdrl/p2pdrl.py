"""Peer-to-peer distillation."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from tensordict import TensorDict

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.p2pdrl.peer_surrogate import PeerSurrogate
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.ppo_stack import PPOStack
from dr_lab.bounds import Count, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.feasible_contexts import feasible_contexts
from dr_lab.seeding import derived_seed, stream
from dr_lab.trajectory import Array


class P2PDRL(Algorithm):
    """Trains N workers by PPO, each in a context that is drawn anew in every iteration, and deploys the first.

    A penalty keeps every worker near its peers. Every iteration collects a whole episode in each slot. The workers
    share a normaliser, so that one can be asked what it would do in the states of another.

    A context of which the first control step shows that it is infeasible is drawn anew: as the workers learn from as
    many control steps each, none would learn.

    Source: Zhao and Hospedales, Robust Domain Randomised Reinforcement Learning through Peer-to-Peer Distillation,
    2021.

    Args:
        interface: what the policies are connected to.
        seed: of everything that is random.
        learner: makes PPO for one worker, from the interface and a seed.
        workers: N.
        alpha: weight of the penalty.
        slots: episodes that run side by side, a multiple of N.
        batch_frames: control steps that are collected at once until every slot has ended an episode.

    Raises:
        ConfigError: a number is out of its range, or the workers cannot share the slots equally.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        learner: Callable[[Interface, int], PPO],
        workers: Count,
        alpha: float,
        slots: Count,
        batch_frames: Count,
    ) -> None:
        self.workers, self.slots, self.batch_frames = workers, slots, batch_frames
        require_bounds(self, "algorithm", P2PDRL)
        members = [learner(interface, derived_seed(seed, "worker", k)) for k in range(workers)]
        for member in members:
            member.actor.normaliser = members[0].actor.normaliser
        self.stack = PPOStack(members, partial(PeerSurrogate, alpha=alpha))
        self.stack.acting.policy_of_slot(slots)  # which it refuses where they cannot share them
        self._rng = stream(seed, "p2pdrl")

    @property
    def policies(self) -> Mapping[str, Policy]:
        """The first worker, which explores, and its peers, whose normaliser is the same."""
        first, *peers = (member.actor for member in self.stack.members)
        return {"policy": first, **{f"peer_{k}": peer for k, peer in enumerate(peers, 1)}}

    @property
    def collecting(self) -> Policy:
        """Each worker, for its own slots."""
        return self.stack.acting

    @property
    def deployed(self) -> Policy:
        """The most likely action of the first worker."""
        return self.stack.members[0].deployed

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """Play a whole episode in each slot, each worker in a new context, and learn from it."""
        owners = [f"worker {k}" for k in range(self.workers)]
        z = feasible_contexts(experience, self._rng, owners, partial(self._first_step, experience))
        return self.update(experience.collect_whole(z.repeat(self.slots // self.workers, axis=0)))

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Let every worker learn from its own slots."""
        return self.stack.update(batch)

    def begin_schedules(self) -> None:
        """Those of the workers."""
        self.stack.begin_schedules()

    def forget_episodes(self) -> None:
        """Those of the workers."""
        self.stack.forget_episodes()

    def explore_anew(self, seed: int) -> None:
        """As every worker does, in other contexts."""
        self.stack.explore_anew(seed)
        self._rng = stream(seed, "explore_anew", "p2pdrl")

    def _first_step(self, experience: Experience, z: Array) -> TensorDict:
        """One control step in each context, of the action in the middle of its bounds."""
        return experience.play(np.tile(self.stack.members[0].actor.centre.cpu().numpy(), (len(z), 1, 1)), z)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"stack": self.stack.state_dict(), "rng": self._rng.bit_generator.state}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.stack.load_state_dict(state["stack"])
        self._rng.bit_generator.state = state["rng"]
