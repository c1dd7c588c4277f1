"""Proximal policy optimisation."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, cast

import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.ppo.gae import advantages
from dr_lab.algorithms.ppo.reward_scale import RewardScale
from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate, Terms
from dr_lab.bounds import Count, Limit, NotNegative, Positive, above, at_least, at_most, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.networks.adam import Adam, clip_norm
from dr_lab.networks.critic import Critic
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.seeding import derived_seed


class PPO(Algorithm):
    """Some epochs of minibatches on every batch, with a loss that forbids large steps (Schulman et al. 2017).

    Args:
        interface: what the policy is connected to.
        seed: of networks, actions and the order of samples.
        actor: makes the policy, from observation width, bounds and seed.
        critic: makes the value network, from observation width and seed.
        surrogate: makes the loss, from both.
        reward_scale: makes what is seen of rewards, from γ.
        batch_frames: control steps in a batch.
        gamma: discount per control step.
        lam: λ of the advantages.
        epochs: passes over a batch.
        minibatch: samples in a step.
        actor_rate: learning rate of the actor.
        critic_rate: learning rate of the critic.
        anneal_frames: control steps over which both rates fall to 0 in a line; None keeps them.
        further_share: share of both rates, kept as it is, with which a policy that is trained already is trained on.
        max_kl: KL(old‖new) at which the actor, not the critic, leaves out the rest of the epochs; None never.
        max_gradient: largest norm of the gradient of both together.
        adam_epsilon: ε of Adam.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        actor: Callable[..., GaussianActor],
        critic: Callable[..., Critic],
        surrogate: Callable[..., Surrogate],
        reward_scale: Callable[[float], RewardScale],
        batch_frames: Annotated[int, at_least(2)],
        gamma: Annotated[float, at_least(0.0), at_most(1.0)],
        lam: Annotated[float, at_least(0.0), at_most(1.0)],
        epochs: Count,
        minibatch: Annotated[int, at_least(2)],
        actor_rate: Positive,
        critic_rate: Positive,
        anneal_frames: Annotated[int | None, above(0)],
        further_share: Annotated[float, above(0.0), at_most(1.0)],
        max_kl: Annotated[float | None, above(0.0)],
        max_gradient: Limit,
        adam_epsilon: NotNegative,
    ) -> None:
        self.batch_frames, self.gamma, self.lam = batch_frames, gamma, lam
        self.epochs, self.minibatch = epochs, minibatch
        self.actor_rate, self.critic_rate = actor_rate, critic_rate
        self.anneal_frames, self.further_share = anneal_frames, further_share
        self.max_kl, self.max_gradient, self.adam_epsilon = max_kl, max_gradient, adam_epsilon
        require_bounds(self, "algorithm", PPO)
        bounds, device = (interface.low, interface.high), interface.device
        self.actor = actor(interface.observation, *bounds, derived_seed(seed, "actor")).to(device)
        self.critic = critic(interface.observation, derived_seed(seed, "critic")).to(device)
        self.surrogate = surrogate(self.actor, self.critic)
        self.reward_scale = reward_scale(gamma)
        self.actor_adam = Adam(self.surrogate.actor_parameters, adam_epsilon)
        self.critic_adam = Adam(self.surrogate.critic_parameters, adam_epsilon)
        self.generator = torch.Generator().manual_seed(derived_seed(seed, "order"))
        self.frames = 0
        self.further = False  # whether a trained policy is trained on

    @property
    def policies(self) -> Mapping[str, Policy]:
        """The stochastic policy."""
        return {"policy": self.actor}

    @property
    def deployed(self) -> Policy:
        """Its most likely action."""
        return self.actor.mean

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Learn from one batch; the normaliser is renewed at the end, so that ρ = 1 at the beginning."""
        figures = self._learn(batch, self.samples(batch))
        self.frames += batch.numel()
        self.actor.normaliser.update(batch["observation"])
        return figures

    @property
    def rate_share(self) -> float:
        """Share of their first size that the learning rates have now."""
        if self.further:
            return self.further_share
        return 1.0 if self.anneal_frames is None else max(0.0, 1.0 - self.frames / self.anneal_frames)

    @torch.no_grad()
    def samples(self, batch: TensorDict) -> PolicySamples:
        """Advantages and value targets of all steps of a batch [n, steps], which is also the shape of the fields.

        The end of an episode in an infeasible context teaches its earlier steps nothing either: A = 0 there, so that
        these bootstrap from its value, as before a time limit, and hear nothing of the reward that was declared.

        Args:
            batch: as a collector gives it.
        """
        observation = self.actor.normaliser(batch["observation"])
        value, next_value = self.critic(observation), self.critic(self.actor.normaliser(batch["next", "observation"]))
        done, terminated = batch["next", "done"].squeeze(-1), batch["next", "terminated"].squeeze(-1)
        earned, infeasible = batch["next", "reward"].squeeze(-1), batch["next", "infeasible"].squeeze(-1)
        reward = torch.where(infeasible, value, self.reward_scale(earned, done, infeasible))
        advantage = advantages(reward, value, next_value, terminated | infeasible, done, self.gamma, self.lam)
        return PolicySamples(
            observation,
            self.actor.unit(batch["action"]),
            batch["action_log_prob"] + self.actor.reach.log().sum(),
            advantage,
            advantage + value,
        )

    def _learn(self, batch: TensorDict, samples: PolicySamples) -> Mapping[str, float]:
        """From all steps but those at which an infeasible context ended an episode: no action led there."""
        every = feasible(batch, samples)
        return self._fit(every, every)

    def _fit(self, policy: PolicySamples, value: PolicySamples) -> Mapping[str, float]:
        """All epochs, of the actor on one set of samples and of the critic on another, which may be the same."""
        learning, objective, error = True, list[Tensor](), list[Tensor]()
        for _ in range(self.epochs):
            together = learning and policy is value
            for terms in self._epoch(value, [self.actor_step, self.critic_step] if together else [self.critic_step]):
                error.append(terms.critic)
                if policy is value:
                    objective.append(-terms.objective)
            if learning and policy is not value:
                objective += [-terms.objective for terms in self._epoch(policy, [self.actor_step])]
            learning = learning and self.may_go_on(policy)
        return {"objective": mean(objective), "critic_loss": mean(error), **self.figures(policy, value)}

    def _epoch(self, samples: PolicySamples, parts: Sequence["Step"]) -> Iterator[Terms]:
        """One pass over the samples, in which these networks learn."""
        for minibatch in samples.minibatches(self.minibatch, self.generator):
            terms = self.surrogate.differentiate(minibatch)
            self.move(parts)
            yield terms

    def move(self, parts: Sequence["Step"]) -> None:
        """Let networks learn by their gradients, whose norm is bounded together."""
        clip_norm([part.gradient for part in parts], self.max_gradient)
        for part in parts:
            part.adam.step(self.rate_share * part.rate)

    @property
    def actor_step(self) -> "Step":
        """What makes the actor learn."""
        return Step(self.surrogate.actor_parameters.gradient, self.actor_adam, self.actor_rate)

    @property
    def critic_step(self) -> "Step":
        """What makes the critic learn."""
        return Step(self.surrogate.critic_parameters.gradient, self.critic_adam, self.critic_rate)

    def may_go_on(self, samples: PolicySamples) -> bool:
        """Whether the actor is still as near to the policy that took these actions as `max_kl` says."""
        return self.max_kl is None or self._divergence(samples)[0] < self.max_kl

    @torch.no_grad()
    def figures(self, policy: PolicySamples, value: PolicySamples) -> dict[str, float]:
        """What became of actor and critic in an update, on the samples that each learnt from."""
        divergence, clipped = self._divergence(policy)
        return {
            "kl": divergence,
            "clipped": clipped,
            "std": self.actor.log_std.exp().mean().item(),
            "explained": 1.0 - ((value.target - self.critic(value.observation)).var() / value.target.var()).item(),
            "learning_rate": self.rate_share * self.actor_rate,
        }

    @torch.no_grad()
    def _divergence(self, samples: PolicySamples) -> tuple[float, float]:
        """KL(old‖new) as E[ρ − 1 − log ρ], and the share of samples whose ρ is clipped."""
        log_ratio = self.actor.unit_log_prob(samples.observation, samples.action) - samples.log_prob
        ratio = log_ratio.exp()
        return (ratio - 1 - log_ratio).mean().item(), ((ratio - 1).abs() > self.surrogate.clip).float().mean().item()

    def begin_schedules(self) -> None:
        """From now on the learning rates are `further_share` of what they were at first.

        Full rates, which are made to fall, would undo in a few batches what was learnt with small ones.
        """
        self.frames, self.further = 0, True

    def forget_episodes(self) -> None:
        """New episodes begin with nothing earned."""
        self.reward_scale.forget_episodes()

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "actor": self.actor.state_dict(),
            "critic": self.critic.state_dict(),
            "actor_adam": self.actor_adam.state_dict(),
            "critic_adam": self.critic_adam.state_dict(),
            "reward_scale": self.reward_scale.state_dict(),
            "generator": self.generator.get_state(),
            "frames": self.frames,
            "further": self.further,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        for part in ("actor", "critic", "actor_adam", "critic_adam", "reward_scale"):
            getattr(self, part).load_state_dict(state[part])
        self.generator.set_state(state["generator"])
        self.frames, self.further = state["frames"], state["further"]


@dataclass(frozen=True)
class Step:
    """What moves one network.

    Attributes:
        gradient: of its parameters, flat.
        adam: its optimiser.
        rate: its learning rate at first.
    """

    gradient: Tensor
    adam: Adam
    rate: float


def feasible(batch: TensorDict, samples: PolicySamples) -> PolicySamples:
    """Samples (n, steps, …) of a batch but those at which an infeasible context ended an episode, one row each."""
    return samples.at(~cast(Tensor, batch["next", "infeasible"]).squeeze(-1))


def mean(terms: Sequence[Tensor]) -> float:
    """Mean of scalars; 0 where there is none."""
    return float(sum(terms, torch.zeros(()))) / max(len(terms), 1)
