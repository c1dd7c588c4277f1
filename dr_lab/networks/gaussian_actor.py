"""A stochastic policy: Gaussian actions around a network's output."""

from collections.abc import Callable, Mapping, Sequence

import torch
from torch import Tensor, nn

from dr_lab.networks.actor import Actor
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.mlp import Activation
from dr_lab.networks.normaliser import Normaliser
from dr_lab.trajectory import Array


class GaussianActor(Actor):
    """a = c + r·u, u ~ N(μ(o), diag σ²), where c ± r are the bounds of the action.

    σ does not depend on the observation. Actions may leave the bounds; the environment cuts them off.

    Attributes: as `Actor`, whose network is μ, and
        log_std: log σ, shape (nu,).

    Args: as `Actor`, and
        log_std: first value of log σ, for actions scaled to ±1.
    """

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
        super().__init__(observation, low, high, seed, normaliser, hidden, activation)
        self.log_std = nn.Parameter(torch.full((len(low),), float(log_std)))

    @torch.no_grad()
    def act(self, observation: Tensor, noise: Tensor) -> Tensor:
        """The action (…, nu) for observations (…, o) to which noise (…, nu) of N(0, 1) leads."""
        policy = Gaussian(self.body(self.normaliser(observation)), self.log_std)
        return self.centre + self.reach * policy.sample(noise)

    @torch.no_grad()
    def mean(self, observation: Tensor) -> Tensor:
        """The most likely action, which is what is deployed."""
        return self.centre + self.reach * self.body(self.normaliser(observation))

    def distribution(self, parameters: Mapping[str, Tensor], observation: Tensor) -> Gaussian:
        """π(u|o) under other parameters than its own; nothing else enters, so that `torch.func` can differentiate it.

        Args:
            parameters: as ``dict(actor.named_parameters())`` names and shapes them.
            observation: normalised already, shape (…, o).
        """
        return Gaussian(self.output(parameters, observation), parameters["log_std"])

    def log_prob(self, observation: Tensor, action: Tensor) -> Tensor:
        """Log π(a|o) of actions (…, nu), shape (…)."""
        return self.unit_log_prob(self.normaliser(observation), self.unit(action)) - self.reach.log().sum(-1)

    def unit_log_prob(self, observation: Tensor, unit: Tensor) -> Tensor:
        """Log π(u|o) of actions scaled to ±1, for observations that are normalised already."""
        return Gaussian(self.body(observation), self.log_std).log_prob(unit)
