"""A value network."""

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from dr_lab.networks.mlp import MLP, Activation


class Critic(nn.Module):
    """V(o); Q(o, a) where the input holds the action too.

    Attributes:
        body: the network.

    Args:
        inputs: width of the input, normalised already.
        seed: of the weights.
        hidden: widths of the hidden layers.
        activation: between them.
    """

    def __init__(self, inputs: int, seed: int, hidden: Sequence[int], activation: Activation) -> None:
        super().__init__()
        generator = torch.Generator().manual_seed(seed)
        self.body = MLP(inputs, hidden, 1, activation, last_gain=1.0, generator=generator)

    def forward(self, inputs: Tensor) -> Tensor:
        """Values (…) of inputs (…, k)."""
        return self.body(inputs).squeeze(-1)
