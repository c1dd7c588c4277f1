"""EPOpt: a policy that is learnt from the contexts in which it does worst."""

from collections.abc import Mapping
from math import ceil
from typing import Annotated, Any, cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.ppo.surrogate import PolicySamples
from dr_lab.bounds import Count, NotNegative, above, at_most, require_bounds
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.errors import ConfigError
from dr_lab.seeding import stream


class EPOpt(PPO):
    """PPO whose policy learns from the share ε of contexts with the lowest return, its critic from all.

    An iteration draws contexts from p(z) and plays each in some slots at once, one whole episode in each slot. Contexts
    are ranked by the mean undiscounted return of these. A slot whose episode ends early plays on in its context, which
    is learnt from and not ranked: else short episodes would count more often. A context with an infeasible episode
    among those ranked is not ranked and not learnt from; an infeasible end of a later one is left out alone. For
    `warm_up` of the control steps ε is 1; learning rates fall only from there on.

    Source: Rajeswaran et al. 2017, algorithm 1, which ranks single episodes (`episodes_per_context` 1).

    Args:
        interface: what the policy is connected to.
        seed: of PPO, and of the contexts.
        epsilon: ε in (0, 1]; 1 keeps all that are feasible.
        warm_up: share of `frames` in which ε is 1, so that there is a policy that can be improved.
        frames: control steps of the run.
        slots: episodes that run side by side, a multiple of `episodes_per_context`.
        episodes_per_context: slots that share a context.
        ppo: the other arguments of `PPO`; `batch_frames` are collected at once until every slot has ended an episode.

    Raises:
        ConfigError: a number is out of its range, the warm-up leaves nothing, or slots cannot be shared equally.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        *,
        epsilon: Annotated[float, above(0.0), at_most(1.0)],
        warm_up: NotNegative,
        frames: int,
        slots: int,
        episodes_per_context: Count,
        **ppo: Any,  # noqa: ANN401 (PPO's own)
    ) -> None:
        super().__init__(interface, seed, **ppo)
        self.epsilon, self.warm_up, self.planned = epsilon, warm_up, frames
        self.slots, self.episodes_per_context = slots, episodes_per_context
        require_bounds(self, "algorithm", EPOpt)
        if warm_up >= 1.0:
            raise ConfigError(
                f"algorithm.warm_up is {warm_up:g} of the {frames} control steps (frames), which leaves nothing to "
                "learn from the worst contexts. Give a share below 1, e.g. algorithm.warm_up=0.3."
            )
        if slots % episodes_per_context:
            raise ConfigError(
                f"algorithm.episodes_per_context is {episodes_per_context}, which does not divide {slots} episodes "
                "side by side. Change one of them: algorithm.episodes_per_context=… episodes=…"
            )
        self.rng = stream(seed, "epopt")

    @property
    def share(self) -> float:
        """ε as it is now."""
        return self.epsilon if self.further or self.frames >= self._start else 1.0

    @property
    def rate_share(self) -> float:
        """As PPO's, but the fall begins when ε does."""
        if self.further or self.anneal_frames is None:
            return super().rate_share
        fallen = (self.frames - self._start) / max(self.anneal_frames - self._start, 1.0)
        return min(1.0, max(0.0, 1.0 - fallen))

    @property
    def _start(self) -> float:
        """Control steps after which ε applies."""
        return self.warm_up * self.planned

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """Play new contexts, each in its slots, and learn from the worst."""
        z = experience.contexts(self.rng, self.slots // self.episodes_per_context)
        return self.update(experience.collect_whole(np.repeat(z, self.episodes_per_context, axis=0)))

    def _learn(self, batch: TensorDict, samples: PolicySamples) -> Mapping[str, float]:
        feasible = ~cast(Tensor, batch["next", "infeasible"]).squeeze(-1)
        if self.share == 1.0:
            every = samples.at(feasible)
            return {**self._fit(every, every), "epsilon": 1.0}
        worst = worst_contexts(batch, self.episodes_per_context, self.share)[:, None].expand_as(feasible)
        return {**self._fit(samples.at(worst & feasible), samples.at(feasible)), "epsilon": self.share}

    def explore_anew(self, seed: int) -> None:
        """As PPO does, in other contexts."""
        super().explore_anew(seed)
        self.rng = stream(seed, "explore_anew", "epopt")

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {"rng": self.rng.bit_generator.state}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.rng.bit_generator.state = state["rng"]


def worst_contexts(batch: TensorDict, episodes_per_context: int, share: float) -> Tensor:
    """Slots of the share of contexts with the lowest mean return, shape (n,).

    ⌈share · contexts⌉ are kept, of those whose episodes are all feasible; fewer where too few are.

    Args:
        batch: size [n, steps], of which every slot begins an episode at the first step and ends it; neighbouring slots
            share a context.
        episodes_per_context: neighbouring slots with one context.
        share: kept.
    """
    reward, infeasible = (cast(Tensor, batch["next", key]).squeeze(-1) for key in ("reward", "infeasible"))
    first = first_episodes(batch)
    returns = torch.where(first, reward, 0.0).sum(1, dtype=torch.float64)
    failed = (infeasible & first).any(1).view(-1, episodes_per_context).any(1)
    means = returns.view(-1, episodes_per_context).mean(1).masked_fill(failed, torch.inf)
    worst = torch.zeros_like(failed)
    kept = ceil(round(share * len(means), 9))  # 0.28 · 25 is a little more than 7
    worst[means.argsort(stable=True)[:kept]] = True
    return (worst & ~failed).repeat_interleave(episodes_per_context)
