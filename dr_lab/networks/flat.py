"""Parameters as one vector, so that an optimiser's step is a handful of operations whatever the number of layers."""

from collections.abc import Iterable, Mapping

import torch
from torch import Tensor, nn

from dr_lab.networks.mlp import MLP


class FlatParameters:
    """Moves parameters into one vector, of which each is then a view; the modules work as before.

    Attributes:
        vector: the parameters, shape (p,).
        gradient: room for their gradient, shape (p,).

    Args:
        parameters: of some modules, each once.
    """

    def __init__(self, parameters: Iterable[nn.Parameter]) -> None:
        self._parameters = list(parameters)
        self.vector = torch.cat([p.detach().flatten() for p in self._parameters])
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
        torch.cat([slope.flatten() for slope in slopes], out=self.gradient)

    def gradients_of(self, body: MLP) -> tuple[list[Tensor], list[Tensor]]:
        """The parts of `gradient` that belong to a network's weights and biases, as `MLP.backward` takes them."""
        weights, biases = ([self.gradient_of(p) for p in part] for part in (body.weights, body.biases))
        return weights, biases

    def _views(self, vector: Tensor) -> list[Tensor]:
        parts = vector.split([p.numel() for p in self._parameters])
        return [part.view(p.shape) for part, p in zip(parts, self._parameters, strict=True)]


def parts_of(vector: Tensor, like: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """The parts of a vector (p,) by name, in the order and shapes of some parameters; `torch.func` goes through it."""
    parts = vector.split([value.numel() for value in like.values()])
    return {name: part.view(value.shape) for part, (name, value) in zip(parts, like.items(), strict=True)}
