"""Proximal policy optimisation."""

from collections.abc import Callable, Mapping
from typing import Any

import torch
from tensordict import TensorDict

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.ppo.gae import advantages
from dr_lab.algorithms.ppo.reward_scale import RewardScale
from dr_lab.algorithms.ppo.selection import Selection
from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate
from dr_lab.collectors.collector import Policy
from dr_lab.errors import require_numbers
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
        selection: makes what chooses the control steps that are learnt from, from γ.
        batch_frames: control steps in a batch.
        gamma: discount per control step.
        lam: λ of the advantages.
        epochs: passes over a batch.
        minibatch: samples in a step.
        actor_rate: learning rate of the actor.
        critic_rate: learning rate of the critic.
        anneal_frames: control steps over which both rates fall to 0 in a line; None keeps them.
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
        selection: Callable[[float], Selection],
        batch_frames: int,
        gamma: float,
        lam: float,
        epochs: int,
        minibatch: int,
        actor_rate: float,
        critic_rate: float,
        anneal_frames: int | None,
        max_kl: float | None,
        max_gradient: float,
        adam_epsilon: float,
    ) -> None:
        self.batch_frames = batch_frames
        self.gamma, self.lam = gamma, lam
        self.epochs, self.minibatch = epochs, minibatch
        self.actor_rate, self.critic_rate = actor_rate, critic_rate
        self.anneal_frames, self.max_kl = anneal_frames, max_kl
        self.max_gradient = max_gradient
        self.adam_epsilon = adam_epsilon
        limits = [name for name in ("anneal_frames", "max_kl") if getattr(self, name) is not None]
        positive = ("actor_rate", "critic_rate", "max_gradient", *limits)
        least = {"batch_frames": 2, "epochs": 1, "minibatch": 2, "gamma": 0.0, "lam": 0.0, "adam_epsilon": 0.0}
        require_numbers(self, "algorithm", positive=positive, least=least, most={"gamma": 1.0, "lam": 1.0})
        self.actor = actor(interface.observation, interface.low, interface.high, derived_seed(seed, "actor"))
        self.critic = critic(interface.observation, derived_seed(seed, "critic"))
        self.surrogate = surrogate(self.actor, self.critic)
        self.reward_scale = reward_scale(gamma)
        self.selection = selection(gamma)
        self.actor_adam = Adam(self.surrogate.actor_parameters, adam_epsilon)
        self.critic_adam = Adam(self.surrogate.critic_parameters, adam_epsilon)
        self.generator = torch.Generator().manual_seed(derived_seed(seed, "order"))
        self.frames = 0

    @property
    def name(self) -> str:
        """PPO, or what it is called with this selection."""
        return self.selection.algorithm

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
        with torch.no_grad():
            samples = self.samples(batch)
        share = 1.0 if self.anneal_frames is None else max(0.0, 1.0 - self.frames / self.anneal_frames)
        figures = self._fit(samples, share)
        self.frames += batch.numel()
        self.actor.normaliser.update(batch["observation"])
        return figures

    def samples(self, batch: TensorDict) -> PolicySamples:
        """Advantages and value targets of the selected steps of a batch [n, steps], one row each.

        Args:
            batch: as a collector gives it.
        """
        observation = self.actor.normaliser(batch["observation"])
        value, next_value = self.critic(observation), self.critic(self.actor.normaliser(batch["next", "observation"]))
        done, terminated = batch["next", "done"].squeeze(-1), batch["next", "terminated"].squeeze(-1)
        earned, infeasible = batch["next", "reward"].squeeze(-1), batch["next", "infeasible"].squeeze(-1)
        reward = self.reward_scale(earned, done, infeasible)
        advantage = advantages(reward, value, next_value, terminated, done, self.gamma, self.lam)
        fields = PolicySamples(
            observation,
            self.actor.unit(batch["action"]),
            batch["action_log_prob"] + self.actor.reach.log().sum(),
            advantage,
            advantage + value,
        )
        kept = self.selection(earned, done, infeasible, next_value * self.reward_scale.unit)
        return PolicySamples(*(field[kept] for field in fields))

    def _fit(self, samples: PolicySamples, share: float) -> Mapping[str, float]:
        """All epochs, with learning rates scaled by `share`."""
        actor, critic = self.surrogate.actor_parameters.gradient, self.surrogate.critic_parameters.gradient
        learning, objective, error, steps = True, 0.0, 0.0, 0
        for _ in range(self.epochs):
            for minibatch in samples.minibatches(self.minibatch, self.generator):
                terms = self.surrogate.differentiate(minibatch)
                clip_norm([actor, critic] if learning else [critic], self.max_gradient)
                if learning:
                    self.actor_adam.step(share * self.actor_rate)
                self.critic_adam.step(share * self.critic_rate)
                objective, error, steps = objective - terms.objective, error + terms.critic, steps + 1
            learning = learning and (self.max_kl is None or self._divergence(samples)[0] < self.max_kl)
        divergence, clipped = self._divergence(samples)
        return {
            "objective": float(objective) / max(steps, 1),
            "critic_loss": float(error) / max(steps, 1),
            "kl": divergence,
            "clipped": clipped,
            "std": self.actor.log_std.exp().mean().item(),
            "explained": 1.0
            - ((samples.target - self.critic(samples.observation)).var() / samples.target.var()).item(),
            "learning_rate": share * self.actor_rate,
        }

    @torch.no_grad()
    def _divergence(self, samples: PolicySamples) -> tuple[float, float]:
        """KL(old‖new) as E[ρ − 1 − log ρ], and the share of samples whose ρ is clipped."""
        log_ratio = self.actor.unit_log_prob(samples.observation, samples.action) - samples.log_prob
        ratio = log_ratio.exp()
        return (ratio - 1 - log_ratio).mean().item(), ((ratio - 1).abs() > self.surrogate.clip).float().mean().item()

    def begin_schedules(self) -> None:
        """The learning rates start at their full size again, and a selection with what it starts with."""
        self.frames = 0
        self.selection.begin_schedules()

    def forget_episodes(self) -> None:
        """New episodes begin with nothing earned."""
        self.reward_scale.forget_episodes()
        self.selection.forget_episodes()

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "actor": self.actor.state_dict(),
            "critic": self.critic.state_dict(),
            "actor_adam": self.actor_adam.state_dict(),
            "critic_adam": self.critic_adam.state_dict(),
            "reward_scale": self.reward_scale.state_dict(),
            "selection": self.selection.state_dict(),
            "generator": self.generator.get_state(),
            "frames": self.frames,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        for part in ("actor", "critic", "actor_adam", "critic_adam", "reward_scale", "selection"):
            getattr(self, part).load_state_dict(state[part])
        self.generator.set_state(state["generator"])
        self.frames = state["frames"]
