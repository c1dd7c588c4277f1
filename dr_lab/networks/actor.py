"""The contract of a policy: a network, and the drawing of actions apart from it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence

import torch
from torch import Tensor, nn
from torch.func import functional_call

from dr_lab.networks.mlp import MLP, Activation
from dr_lab.networks.normaliser import Normaliser
from dr_lab.trajectory import Array


class Actor(nn.Module, ABC):
    """Actions a = c + r·u, where c ± r are their bounds and u comes from a network's output for the observation.

    Attributes:
        normaliser: what comes before the network.
        body: the network, from normalised observations (…, o) to (…, nu).
        centre: c, shape (nu,).
        reach: r, shape (nu,).
        generator: random numbers of the actions.

    Args:
        observation: width of observations.
        low: lowest action, shape (nu,).
        high: highest action, shape (nu,).
        seed: of weights and actions.
        normaliser: makes a normaliser for a width of observations.
        hidden: widths of the hidden layers.
        activation: between them.
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
    ) -> None:
        super().__init__()
        self.generator = torch.Generator().manual_seed(seed)
        self.normaliser = normaliser(observation)
        self.body = MLP(observation, hidden, len(low), activation, last_gain=0.01, generator=self.generator)
        self.register_buffer("centre", torch.as_tensor((low + high) / 2, dtype=torch.float32))
        self.register_buffer("reach", torch.as_tensor((high - low) / 2, dtype=torch.float32))

    @torch.no_grad()
    def forward(self, observation: Tensor) -> Tensor:
        """An action (n, nu) drawn for observations (n, o)."""
        noise = self.reach.new_empty((*observation.shape[:-1], len(self.reach)))
        return self.act(observation, noise.normal_(generator=self.generator))

    @abstractmethod
    def act(self, observation: Tensor, noise: Tensor) -> Tensor:
        """The action (…, nu) for observations (…, o) to which noise (…, nu) of N(0, 1) leads."""

    @abstractmethod
    def mean(self, observation: Tensor) -> Tensor:
        """The action (…, nu) without noise, which is what is deployed."""

    def output(self, parameters: Mapping[str, Tensor], observation: Tensor) -> Tensor:
        """What the network makes of normalised observations (…, o) under other parameters than its own.

        Args:
            parameters: as ``dict(actor.named_parameters())`` names and shapes them.
            observation: normalised already.
        """
        body = {name: parameters[f"body.{name}"] for name, _ in self.body.named_parameters()}
        return functional_call(self.body, body, (observation,))

    def unit(self, action: Tensor) -> Tensor:
        """U = (a − c)/r."""
        return (action - self.centre) / self.reach

    def reseed(self, seed: int) -> None:
        """Draw actions by the random numbers of this seed from here on."""
        self.generator.manual_seed(seed)

    def get_extra_state(self) -> Tensor:
        """State of the random numbers, so that `state_dict` says all that the next action depends on."""
        return self.generator.get_state()

    def set_extra_state(self, state: Tensor) -> None:
        """Go on with these random numbers."""
        self.generator.set_state(state)
