"""A deterministic policy, with noise while it explores."""

from collections.abc import Callable, Mapping, Sequence

import torch
from torch import Tensor

from dr_lab.bounds import NotNegative, require_bounds
from dr_lab.networks.actor import Actor
from dr_lab.networks.mlp import Activation
from dr_lab.networks.normaliser import Normaliser
from dr_lab.trajectory import Array


class DeterministicActor(Actor):
    """a = c + r·tanh(f(o)), where c ± r are the bounds of the action.

    Attributes: as `Actor`, whose network is f.

    Args: as `Actor`, and
        noise: standard deviation of the noise while exploring, for actions scaled to ±1.

    Raises:
        ConfigError: a number is out of its range.
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
        noise: NotNegative,
    ) -> None:
        super().__init__(observation, low, high, seed, normaliser, hidden, activation)
        self.noise = noise
        require_bounds(self, "algorithm.actor", DeterministicActor)

    @torch.no_grad()
    def act(self, observation: Tensor, noise: Tensor) -> Tensor:
        """The exploring action (…, nu), within the bounds, to which noise (…, nu) of N(0, 1) leads."""
        unit = self.body(self.normaliser(observation)).tanh()
        unit += self.noise * noise
        return self.centre + self.reach * unit.clamp_(-1.0, 1.0)

    @torch.no_grad()
    def mean(self, observation: Tensor) -> Tensor:
        """The action without noise, which is what is deployed."""
        return self.centre + self.reach * self.body(self.normaliser(observation)).tanh()

    def unit_action(self, parameters: Mapping[str, Tensor], observation: Tensor) -> Tensor:
        """The action (…, nu) scaled to ±1 under other parameters than its own; nothing else enters.

        Args:
            parameters: as ``dict(actor.named_parameters())`` names and shapes them.
            observation: normalised already, shape (…, o).
        """
        return self.output(parameters, observation).tanh()
