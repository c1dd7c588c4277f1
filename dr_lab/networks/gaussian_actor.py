"""A stochastic policy: Gaussian actions around a network's output."""

import math
from collections.abc import Callable, Sequence

import torch
from torch import Tensor, nn

from dr_lab.networks.mlp import MLP, Activation
from dr_lab.networks.normaliser import Normaliser
from dr_lab.trajectory import Array

_LOG_2_PI = math.log(2.0 * math.pi)


class GaussianActor(nn.Module):
    """a = c + r·u, u ~ N(μ(o), diag σ²), where c ± r are the bounds of the action.

    σ does not depend on the observation. Actions may leave the bounds; the environment cuts them off.

    Attributes:
        normaliser: what comes before the network.
        body: μ.
        log_std: log σ, shape (nu,).

    Args:
        observation: width of observations.
        low: lowest action, shape (nu,).
        high: highest action, shape (nu,).
        seed: of weights and actions.
        normaliser: makes a normaliser for a width of observations.
        hidden: widths of the hidden layers.
        activation: between them.
        log_std: first value of log σ, for actions scaled to ±1.
    """

    centre: Tensor
    reach: Tensor

    def __init__(
        self,
        observation: int,
        low: Array,
        high: Array,
        seed: int,
        normaliser: Callable[[int], Normaliser],
        hidden: Sequence[int],
        activation: Activation,
        log_std: float,
    ) -> None:
        super().__init__()
        self.generator = torch.Generator().manual_seed(seed)
        self.normaliser = normaliser(observation)
        self.body = MLP(observation, hidden, len(low), activation, last_gain=0.01, generator=self.generator)
        self.log_std = nn.Parameter(torch.full((len(low),), float(log_std)))
        self.register_buffer("centre", torch.as_tensor((low + high) / 2, dtype=torch.float32))
        self.register_buffer("reach", torch.as_tensor((high - low) / 2, dtype=torch.float32))

    @torch.no_grad()
    def forward(self, observation: Tensor) -> Tensor:
        """A random action (n, nu) for observations (n, o)."""
        mean = self.body(self.normaliser(observation))
        noise = torch.empty_like(mean).normal_(generator=self.generator)
        return self.centre + self.reach * (mean + self.log_std.exp() * noise)

    @torch.no_grad()
    def mean(self, observation: Tensor) -> Tensor:
        """The most likely action, which is what is deployed."""
        return self.centre + self.reach * self.body(self.normaliser(observation))

    def log_prob(self, observation: Tensor, action: Tensor) -> Tensor:
        """Log π(a|o) of actions (…, nu), shape (…)."""
        return self.unit_log_prob(self.normaliser(observation), self.unit(action)) - self.reach.log().sum()

    def unit_log_prob(self, observation: Tensor, unit: Tensor) -> Tensor:
        """Log π(u|o) of actions scaled to ±1, for observations that are normalised already."""
        return unit_log_prob(self.body(observation), self.log_std, unit)

    def unit(self, action: Tensor) -> Tensor:
        """U = (a − c)/h."""
        return (action - self.centre) / self.reach

    def get_extra_state(self) -> Tensor:
        """State of the random numbers, so that `state_dict` says all that the next action depends on."""
        return self.generator.get_state()

    def set_extra_state(self, state: Tensor) -> None:
        """Go on with these random numbers."""
        self.generator.set_state(state)


def unit_log_prob(mean: Tensor, log_std: Tensor, unit: Tensor) -> Tensor:
    """Log N(u; μ, diag σ²) over the last dimension."""
    z = (unit - mean) * (-log_std).exp()
    return -0.5 * (z * z).sum(-1) - log_std.sum() - 0.5 * mean.shape[-1] * _LOG_2_PI


def unit_entropy(log_std: Tensor) -> Tensor:
    """Entropy of N(·, diag σ²) in nats."""
    return log_std.sum() + 0.5 * len(log_std) * (1.0 + _LOG_2_PI)
