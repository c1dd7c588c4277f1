"""Parameters as one vector, so that an optimiser's step is a handful of operations whatever the number of layers."""

import math
from collections.abc import Iterable, Mapping, Sequence

import torch
from torch import Tensor, nn

from dr_lab.networks.mlp import MLP


class FlatParameters:
    """Moves parameters into one vector, of which each is then a view; the modules work as before.

    Attributes:
        vector: the parameters, shape (p,); of a stack of networks (N, p).
        gradient: room for their gradient, in the same shape.

    Args:
        parameters: of some modules, each once.
        stack: dimensions that come before those of each parameter: (N,) of a stack of N networks.
    """

    def __init__(self, parameters: Iterable[nn.Parameter], stack: Sequence[int] = ()) -> None:
        self._parameters, self._stack = list(parameters), tuple(stack)
        self.vector = self._joined([p.detach() for p in self._parameters])
        self.gradient = torch.zeros_like(self.vector)
        for parameter, view in zip(self._parameters, self._views(self.vector), strict=True):
            parameter.data = view
        self._gradients = dict(zip(map(id, self._parameters), self._views(self.gradient), strict=True))

    def gradient_of(self, parameter: nn.Parameter) -> Tensor:
        """The part of `gradient` that belongs to one parameter, in its shape."""
        return self._gradients[id(parameter)]

    def differentiate(self, loss: Tensor, *, keep_graph: bool = False) -> None:
        """Write ∂loss/∂parameters into `gradient` by autograd."""
        slopes = torch.autograd.grad(loss, self._parameters, retain_graph=keep_graph)
        self.gradient.copy_(self._joined(slopes))

    def gradients_of(self, body: MLP) -> tuple[list[Tensor], list[Tensor]]:
        """The parts of `gradient` that belong to a network's weights and biases, as `MLP.backward` takes them."""
        return [self.gradient_of(p) for p in body.weights], [self.gradient_row_of(p) for p in body.biases]

    def gradient_row_of(self, parameter: nn.Parameter) -> Tensor:
        """The part of `gradient` that belongs to a vector (k,), as a row (1, k); of a stack it is one, (N, 1, k)."""
        return torch.atleast_2d(self.gradient_of(parameter))

    def _joined(self, values: Sequence[Tensor]) -> Tensor:
        return torch.cat([value.reshape(*self._stack, -1) for value in values], -1)

    def _views(self, vector: Tensor) -> list[Tensor]:
        share = math.prod(self._stack)
        parts = vector.split([p.numel() // share for p in self._parameters], -1)
        return [part.view(p.shape) for part, p in zip(parts, self._parameters, strict=True)]


def parts_of(vector: Tensor, like: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The parts of a vector (p,) by name, in the order and shapes of some parameters; `torch.func` goes through it."""
    parts = vector.split([value.numel() for value in like.values()])
    return {name: part.view(value.shape) for part, (name, value) in zip(parts, like.items(), strict=True)}
