"""DDPG's losses with their gradients written out: half of the time that TorchRL and autograd take."""

import copy
import functools
from collections.abc import Mapping, Sequence
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
    """L_Q = E[(Q(o, a) − y)²] with y = r + γ Q'(o', μ'(o')) where o' is no end, and L_μ = E[c·f²/nu − Q(o, μ(o))].

    μ = tanh ∘ f is in units of the action's bounds, and f² sums over the action. Q' and μ' are targets that follow
    slowly. Without c equal to TorchRL's `DDPGLoss` with its targets delayed, in value and gradient. With c, f stays
    where tanh still has a slope, along which the actor can leave an action at its bound.

    Source: Lillicrap et al. 2016, algorithm 1; c as Andrychowicz et al. 2017, appendix A.

    Args:
        actor: its body is f.
        critics: Q; where there are several, L_Q is the sum of theirs, Q' the least of them, and L_μ is of the first.
        gamma: γ, discount per control step.
        saturation_cost: c, in the reward's unit.

    Attributes:
        actor_parameters: of μ, with room for ∂L_μ.
        critic_parameters: of the critics, with room for ∂L_Q.
    """

    def __init__(
        self, actor: DeterministicActor, critics: Sequence[Critic], gamma: float, saturation_cost: float
    ) -> None:
        self._gamma, self._saturation_cost = gamma, saturation_cost
        self._actor, self._critics = actor.body, [critic.body for critic in critics]
        self._late_actor, self._late_critics = copy.deepcopy(self._actor), copy.deepcopy(self._critics)
        self.actor_parameters, self.critic_parameters, self._late = (
            FlatParameters([p for body in bodies for p in body.parameters()])
            for bodies in ([self._actor], self._critics, [self._late_actor, *self._late_critics])
        )
        self._actor_gradients = self.actor_parameters.gradients_of(actor.body)
        self._critic_gradients = [self.critic_parameters.gradients_of(critic) for critic in self._critics]

    @torch.no_grad()
    def differentiate_critics(self, batch: Transitions) -> tuple[Tensor, Tensor]:
        """L_Q and the mean of Q(o, a); the gradient is in `critic_parameters` then."""
        then = torch.cat([batch.after, self._late_action(batch.after)], 1)
        values = [critic(then) for critic in self._late_critics]
        target = batch.reward + self._gamma * functools.reduce(torch.minimum, values) * ~batch.terminated
        now, loss, layers = torch.cat([batch.observation, batch.action], 1), torch.zeros(()), list[Tensor]()
        for critic, gradients in zip(self._critics, self._critic_gradients, strict=True):
            layers = critic.layers(now)
            error = layers[-1] - target
            critic.backward(layers, error * (2.0 / len(error)), *gradients)
            loss = loss + error.square().mean()
        return loss, layers[-1].mean()

    @torch.no_grad()
    def differentiate_actor(self, observation: Tensor) -> Tensor:
        """L_μ; the gradient is in `actor_parameters` then."""
        layers, critic = self._actor.layers(observation), self._critics[0]
        action = layers[-1].tanh()
        judged = critic.layers(torch.cat([observation, action], 1))
        slope = critic.input_slope(judged, torch.full_like(judged[-1], -1.0 / len(action)))
        slope = torch.ops.aten.tanh_backward.default(slope[:, observation.shape[1] :], action)
        slope += layers[-1] * (2.0 * self._saturation_cost / action.numel())
        self._actor.backward(layers, slope, *self._actor_gradients)
        return self._saturation_cost * layers[-1].square().mean() - judged[-1].mean()

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

    def _late_action(self, observation: Tensor) -> Tensor:
        """μ'(o), shape (b, nu)."""
        return self._late_actor(observation).tanh_()
