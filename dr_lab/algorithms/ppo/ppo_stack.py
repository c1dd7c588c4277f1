"""Proximal policy optimisation of many policies side by side."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np
import torch
from tensordict import TensorDict

from dr_lab.algorithms.ppo.ppo import PPO, feasible, mean
from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate
from dr_lab.algorithms.ppo.surrogate_stack import SurrogateStack
from dr_lab.networks.policy_stack import GaussianPolicyStack
from dr_lab.seeding import derived_seed


class PPOStack:
    """N policies, each of which PPO trains on its own slots, as it would alone: only the gradients are found together.

    Learning rates fall with the control steps of all.

    Args:
        members: N instances of PPO, made alike.
        surrogate: makes what finds their gradients together.

    Attributes:
        members: N instances of PPO.
        acting: their policies, which share the slots.
    """

    def __init__(
        self,
        members: Sequence[PPO],
        surrogate: Callable[[Sequence[Surrogate]], SurrogateStack] = SurrogateStack,
    ) -> None:
        self.members = members
        self.acting = GaussianPolicyStack([member.actor for member in members])
        self.surrogate = surrogate([member.surrogate for member in members])

    def update(self, batch: TensorDict) -> dict[str, float]:
        """Let every policy learn from its own slots of a batch; gives means of PPO's figures."""
        parts = cast(Sequence[TensorDict], batch.chunk(len(self.members)))
        samples = [feasible(part, member.samples(part)) for member, part in zip(self.members, parts, strict=True)]
        figures = self._fit(self._of_one_size(samples))
        for member, part in zip(self.members, parts, strict=True):
            member.frames += batch.numel()
            member.actor.normaliser.update(part["observation"])
        self.acting.refresh()
        return figures

    def begin_schedules(self) -> None:
        """Those of every policy."""
        for member in self.members:
            member.begin_schedules()

    def forget_episodes(self) -> None:
        """Those of every policy."""
        for member in self.members:
            member.forget_episodes()

    def explore_anew(self, seed: int) -> None:
        """As every policy does, by other random numbers each."""
        for k, member in enumerate(self.members):
            member.explore_anew(derived_seed(seed, "member", k))

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"members": [member.state_dict() for member in self.members]}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        for member, each in zip(self.members, state["members"], strict=True):
            member.load_state_dict(each)
        self.acting.refresh()

    def _fit(self, samples: Sequence[PolicySamples]) -> dict[str, float]:
        """All epochs; an actor that has come too far rests, while the others go on."""
        like, learning, terms = self.members[0], [True] * len(self.members), []
        for _ in range(like.epochs):
            orders = [
                each.minibatches(member.minibatch, member.generator)
                for member, each in zip(self.members, samples, strict=True)
            ]
            for minibatches in zip(*orders, strict=True):
                terms.append(self.surrogate.differentiate(minibatches))
                for member, learns in zip(self.members, learning, strict=True):
                    member.move([member.actor_step, member.critic_step] if learns else [member.critic_step])
            learning = [
                learns and member.may_go_on(each)
                for learns, member, each in zip(learning, self.members, samples, strict=True)
            ]
        every = [member.figures(each, each) for member, each in zip(self.members, samples, strict=True)]
        return {
            "objective": mean([-each.objective.mean() for each in terms]),
            "critic_loss": mean([each.critic.mean() for each in terms]),
            **{key: float(np.mean([figures[key] for figures in every])) for key in every[0]},
        }

    def _of_one_size(self, samples: Sequence[PolicySamples]) -> list[PolicySamples]:
        """As many of each policy's as there are of every one's, drawn at random where infeasible steps are missing."""
        least = min(len(each.target) for each in samples)
        found = list[PolicySamples]()
        for member, each in zip(self.members, samples, strict=True):
            rows = len(each.target)
            if rows > least:
                kept = torch.randperm(rows, generator=member.generator)[:least].to(each.target.device)
                each = PolicySamples(*(field[kept] for field in each))  # noqa: PLW2901 (fewer of the same)
            found.append(each)
        return found
