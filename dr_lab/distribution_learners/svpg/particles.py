"""N actor-critics over the unit cube, and what their actors are to climb."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor, nn

from dr_lab.distribution_learners.svpg.stacked import Stacked
from dr_lab.distribution_learners.svpg.walk import WalkStep
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.mlp import MLP

_FIRST = 0.01  # gain of the last layers: walks begin without a drift, values near 0


class WalkActor(nn.Module):
    """π(a|u) = N(μ(u), diag σ²), whose μ and log σ stand side by side in the result.

    Args:
        size: n, of u and a.
        hidden: widths of the hidden layers of μ, with tanh between them.
        generator: random numbers for the weights.
    """

    def __init__(self, size: int, hidden: Sequence[int], generator: torch.Generator) -> None:
        super().__init__()
        self.body = MLP(size, hidden, size, "tanh", _FIRST, generator)
        self.log_std = nn.Parameter(torch.zeros(size))

    def forward(self, u: Tensor) -> Tensor:
        """μ and log σ, shape (…, 2n), at points (…, n)."""
        mean = self.body(u)
        return torch.cat([mean, self.log_std.expand_as(mean)], -1)


class Gradients(NamedTuple):
    """Of the actors' objectives and the critics' losses.

    Attributes:
        actor: ∇J of each particle's actor, shape (N, p).
        critic: ∇ of the sum of the critics' losses, shape (N, q).
        loss: mean loss of the critics.
    """

    actor: Tensor
    critic: Tensor
    loss: float


class Particles:
    """N advantage actor-critics (A2C).

    With rewards rₜ for where step t led to, and the value V(uₜ₊₁) of what comes where the walk or what is known of it
    ends,

        Rₜ = rₜ + γ Rₜ₊₁,   ∇J = Σₜ (Rₜ − V(uₜ)) ∇ log π(aₜ|uₜ),   L = ½ Σₜ (Rₜ − V(uₜ))².

    Attributes:
        actors: θ, which are the particles.
        critics: V. They are no particles: what a critic is to be follows from its actor, and it keeps no distance.

    Args:
        count: N.
        size: n.
        generator: random numbers for the weights.
        hidden: widths of the hidden layers of actor and critic.
        gamma: γ, per step of a walk.
    """

    def __init__(self, count: int, size: int, generator: torch.Generator, hidden: Sequence[int], gamma: float) -> None:
        self.gamma = gamma
        self.actors = Stacked([WalkActor(size, hidden, generator) for _ in range(count)])
        self.critics = Stacked([MLP(size, hidden, 1, "tanh", _FIRST, generator) for _ in range(count)])

    def policy(self, u: Tensor) -> Gaussian:
        """π(·|u) of each particle at its points (N, …, n)."""
        return Gaussian(*self.actors(u).chunk(2, -1))

    def values(self, u: Tensor) -> Tensor:
        """V(u) of each particle at its points (N, …, n), shape (N, …)."""
        return self.critics(u).squeeze(-1)

    def cost(self, u: Tensor) -> Tensor:
        """What it costs each particle to act as it does at its points (N, k, n), shape (N, k): nothing."""
        return u.new_zeros(u.shape[:-1])

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Take over what the particles of another run have learnt."""
        self.load_state_dict(state)

    def state_dict(self) -> dict[str, Any]:
        """All parameters."""
        return {"actors": self.actors.state_dict(), "critics": self.critics.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.actors.load_state_dict(state["actors"])
        self.critics.load_state_dict(state["critics"])

    def gradients(self, steps: Sequence[WalkStep], rewards: Tensor) -> Gradients:
        """What the steps of the walks teach.

        Args:
            steps: k of them, in the order of time.
            rewards: of where each led to, shape (N, k).
        """
        before, action, after, cut = (torch.stack(part, 1) for part in zip(*steps, strict=True))
        known = self.values(before)
        cost = self.cost(before)
        returns = discounted(rewards - cost.detach(), self.values(after).detach(), cut, self.gamma)
        advantage = returns - known
        objective = (self.policy(before).log_prob(action) * advantage.detach() - cost).sum()
        loss = 0.5 * advantage.square().sum()
        (actor,) = torch.autograd.grad(objective, self.actors.rows)
        (critic,) = torch.autograd.grad(loss, self.critics.rows)
        return Gradients(actor, critic, loss.item() / advantage.numel())


def discounted(rewards: Tensor, after: Tensor, cut: Tensor, gamma: float) -> Tensor:
    """Rₜ = rₜ + γ·(V(uₜ₊₁) where the walk was cut after step t or t is the last step, else Rₜ₊₁).

    Args:
        rewards: rₜ, shape (N, k).
        after: V(uₜ₊₁), shape (N, k).
        cut: whether the walk was cut, shape (N, k).
        gamma: γ.

    Returns:
        Shape (N, k).
    """
    returns, following = list[Tensor](), after[:, -1]
    for t in reversed(range(rewards.shape[1])):
        following = rewards[:, t] + gamma * torch.where(cut[:, t], after[:, t], following)
        returns.append(following)
    return torch.stack(returns[::-1], 1)
