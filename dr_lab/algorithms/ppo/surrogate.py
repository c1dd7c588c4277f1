"""The contract of a PPO loss, and what it is computed from."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import torch
from torch import Tensor
from torch.func import functional_call

from dr_lab.algorithms.ppo.clipped import clipped
from dr_lab.bounds import Positive, require_bounds
from dr_lab.networks.critic import Critic
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian_actor import GaussianActor

_LEAST_STD = 1e-6  # of advantages, as TorchRL has it


class PolicySamples(NamedTuple):
    """Control steps to learn from, b of them.

    Attributes:
        observation: normalised, shape (b, o).
        action: scaled to ±1, shape (b, nu).
        log_prob: of that action under the policy that took it, shape (b,).
        advantage: A, shape (b,).
        target: what the critic shall say, shape (b,).
    """

    observation: Tensor
    action: Tensor
    log_prob: Tensor
    advantage: Tensor
    target: Tensor

    def at(self, chosen: Tensor) -> "PolicySamples":
        """Those of fields (n, steps, …) that are chosen, shape (n, steps), one row each."""
        return PolicySamples(*(field[chosen] for field in self))

    def minibatches(self, size: int, generator: torch.Generator) -> Iterator["PolicySamples"]:
        """All of them once, in random order, `size` at a time; a remainder smaller than two is left out."""
        order = torch.randperm(len(self.target), generator=generator).to(self.target.device)
        for parts in zip(*(field[order].split(size) for field in self), strict=True):
            if len(parts[0]) > 1:  # advantages are standardised within a minibatch
                yield PolicySamples(*parts)

    def standardised_advantage(self) -> Tensor:
        """(A − mean A)/std A, shape (b,)."""
        std, mean = torch.std_mean(self.advantage, -1, keepdim=True)
        return (self.advantage - mean) / std.clamp(min=_LEAST_STD)


class Terms(NamedTuple):
    """A loss on one minibatch, its parts weighted as they enter the sum.

    Attributes:
        objective: −E[min(ρA, clip(ρ)A)].
        entropy: −weight·H.
        critic: weight·E[(V − target)²].
    """

    objective: Tensor
    entropy: Tensor
    critic: Tensor


class Surrogate(ABC):
    """L = −E[min(ρA, clip(ρ, 1 ± ε)A)] − c_H·H + c_V·E[(V − target)²] with ρ = π(a|o)/π_old(a|o).

    A is standardised within the minibatch. The first two parts depend on the actor alone, the last on the critic.

    Source: Schulman et al. 2017, equations 7 and 9.

    Attributes:
        actor: π.
        critic: V.

    Args:
        actor: π.
        critic: V.
        clip: ε.
        entropy_weight: c_H.
        critic_weight: c_V.

    Raises:
        ConfigError: ε is not above 0.
    """

    def __init__(
        self, actor: GaussianActor, critic: Critic, clip: Positive, entropy_weight: float, critic_weight: float
    ) -> None:
        self.actor, self.critic = actor, critic
        stack = actor.log_std.shape[:-2]  # none of a single policy's, (N,) of a stack's
        self.actor_parameters = FlatParameters([actor.log_std, *actor.body.parameters()], stack)
        self.critic_parameters = FlatParameters(critic.parameters(), stack)
        self.clip = clip
        self.entropy_weight = entropy_weight
        self.critic_weight = critic_weight
        require_bounds(self, "algorithm.surrogate", Surrogate)

    def actor_loss(self, parameters: Mapping[str, Tensor], samples: PolicySamples) -> Tensor:
        """−E[min(ρA, clip(ρ, 1 ± ε)A)] − c_H·H under other parameters than the actor's own.

        A pure function that `torch.func` can differentiate, to the second order too.

        Args:
            parameters: of π, as ``dict(actor.named_parameters())`` names and shapes them.
            samples: the minibatch.
        """
        policy = self.actor.distribution(parameters, samples.observation)
        ratio = (policy.log_prob(samples.action) - samples.log_prob).exp()
        advantage = samples.standardised_advantage()
        return -clipped(ratio, advantage, self.clip).mean() - self.entropy_weight * policy.entropy()

    def critic_loss(self, parameters: Mapping[str, Tensor], samples: PolicySamples) -> Tensor:
        """c_V·E[(V − target)²] under other parameters than the critic's own, as pure as `actor_loss`."""
        value = functional_call(self.critic, dict(parameters), (samples.observation,))
        return self.critic_weight * (value - samples.target).square().mean()

    @abstractmethod
    def differentiate(self, samples: PolicySamples) -> Terms:
        """The loss; its gradient is in `actor_parameters.gradient` and `critic_parameters.gradient` afterwards."""
