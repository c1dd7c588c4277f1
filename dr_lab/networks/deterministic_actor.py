"""A deterministic policy, with noise while it explores."""

from collections.abc import Callable, Sequence

import torch
from torch import Tensor, nn

from dr_lab.errors import require_numbers
from dr_lab.networks.mlp import MLP, Activation
from dr_lab.networks.normaliser import Normaliser
from dr_lab.trajectory import Array


class DeterministicActor(nn.Module):
    """a = c + r·tanh(f(o)), where c ± r are the bounds of the action.

    Args:
        observation: width of observations.
        low: lowest action, shape (nu,).
        high: highest action, shape (nu,).
        seed: of weights and noise.
        normaliser: makes a normaliser for a width of observations.
        hidden: widths of the hidden layers.
        activation: between them.
        noise: standard deviation of the noise while exploring, for actions scaled to ±1.

    Raises:
        ConfigError: a number is out of its range.
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
        noise: float,
    ) -> None:
        super().__init__()
        self.noise = noise
        require_numbers(self, "algorithm.actor", least={"noise": 0.0})
        self.generator = torch.Generator().manual_seed(seed)
        self.normaliser = normaliser(observation)
        self.body = MLP(observation, hidden, len(low), activation, last_gain=0.01, generator=self.generator)
        self.register_buffer("centre", torch.as_tensor((low + high) / 2, dtype=torch.float32))
        self.register_buffer("reach", torch.as_tensor((high - low) / 2, dtype=torch.float32))

    @torch.no_grad()
    def forward(self, observation: Tensor) -> Tensor:
        """An exploring action (n, nu) for observations (n, o), within the bounds."""
        unit = self.body(self.normaliser(observation)).tanh()
        unit += self.noise * torch.empty_like(unit).normal_(generator=self.generator)
        return self.centre + self.reach * unit.clamp_(-1.0, 1.0)

    @torch.no_grad()
    def mean(self, observation: Tensor) -> Tensor:
        """The action without noise, which is what is deployed."""
        return self.centre + self.reach * self.body(self.normaliser(observation)).tanh()

    def unit(self, action: Tensor) -> Tensor:
        """(a − c)/r."""
        return (action - self.centre) / self.reach

    def get_extra_state(self) -> Tensor:
        """State of the random numbers."""
        return self.generator.get_state()

    def set_extra_state(self, state: Tensor) -> None:
        """Go on with these random numbers."""
        self.generator.set_state(state)
