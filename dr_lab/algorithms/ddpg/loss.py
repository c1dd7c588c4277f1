"""DDPG's losses with their gradients written out: half of the time that TorchRL and autograd take."""

import copy
from collections.abc import Mapping
from typing import Any, NamedTuple

import torch
from torch import Tensor

from dr_lab.networks.critic import Critic
from dr_lab.networks.deterministic_actor import DeterministicActor
from dr_lab.networks.flat import FlatParameters


class Transitions(NamedTuple):
    """Control steps to learn from, b of them.

    Attributes:
        observation: normalised, shape (b, o).
        action: scaled to ±1, shape (b, nu).
        reward: shape (b, 1).
        after: the next observation, normalised, shape (b, o).
        terminated: whether the episode came to its end there, shape (b, 1).
    """

    observation: Tensor
    action: Tensor
    reward: Tensor
    after: Tensor
    terminated: Tensor


class DDPGLoss:
    """L_Q = E[(Q(o, a) − y)²] with y = r + γ Q'(o', μ'(o')) where o' is no end, and L_μ = −E[Q(o, μ(o))].

    μ = tanh ∘ body is in units of the action's bounds. Q' and μ' are targets that follow slowly. Equal to TorchRL's
    `DDPGLoss` with its targets delayed, in value and gradient.

    Source: Lillicrap et al. 2016, algorithm 1.

    Args:
        actor: its body is that of μ.
        critic: Q.
        gamma: γ, discount per control step.

    Attributes:
        actor_parameters: of μ, with room for ∂L_μ.
        critic_parameters: of Q, with room for ∂L_Q.
    """

    def __init__(self, actor: DeterministicActor, critic: Critic, gamma: float) -> None:
        self._gamma = gamma
        self._actor, self._critic = actor.body, critic.body
        self._late_actor, self._late_critic = copy.deepcopy(actor.body), copy.deepcopy(critic.body)
        self.actor_parameters, self.critic_parameters, self._late = (
            FlatParameters([p for body in bodies for p in body.parameters()])
            for bodies in ([actor.body], [critic.body], [self._late_actor, self._late_critic])
        )
        self._actor_gradients = self.actor_parameters.gradients_of(actor.body)
        self._critic_gradients = self.critic_parameters.gradients_of(critic.body)

    @torch.no_grad()
    def differentiate(self, batch: Transitions) -> tuple[Tensor, Tensor, Tensor]:
        """L_Q, L_μ and the mean of Q(o, a); the gradients are in `critic_parameters` and `actor_parameters` then."""
        critic_loss, value = self._differentiate_critic(batch)
        return critic_loss, self._differentiate_actor(batch.observation), value

    @torch.no_grad()
    def follow(self, tau: float) -> None:
        """Let the targets follow: θ' ← θ' + τ (θ − θ')."""
        now = (self.actor_parameters.vector, self.critic_parameters.vector)
        for late, vector in zip(self._late.vector.split([len(vector) for vector in now]), now, strict=True):
            late.lerp_(vector, tau)

    def state_dict(self) -> dict[str, Any]:
        """The targets."""
        return {"late": self._late.vector.clone()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on with the targets of a `state_dict`."""
        self._late.vector.copy_(state["late"])

    def _differentiate_critic(self, batch: Transitions) -> tuple[Tensor, Tensor]:
        then = torch.cat([batch.after, self._late_actor(batch.after).tanh_()], 1)
        target = batch.reward + self._gamma * self._late_critic(then) * ~batch.terminated
        layers = self._critic.layers(torch.cat([batch.observation, batch.action], 1))
        error = layers[-1] - target
        self._critic.backward(layers, error * (2.0 / len(error)), *self._critic_gradients)
        return error.square().mean(), layers[-1].mean()

    def _differentiate_actor(self, observation: Tensor) -> Tensor:
        layers = self._actor.layers(observation)
        action = layers[-1].tanh()
        judged = self._critic.layers(torch.cat([observation, action], 1))
        slope = self._critic.input_slope(judged, torch.full_like(judged[-1], -1.0 / len(action)))
        slope = torch.ops.aten.tanh_backward.default(slope[:, observation.shape[1] :], action)
        self._actor.backward(layers, slope, *self._actor_gradients)
        return -judged[-1].mean()
