"""Many networks of one architecture, whose parameters are the rows of one matrix."""

import copy
from collections.abc import Sequence
from typing import Self

import torch
from torch import Tensor, nn
from torch.func import functional_call, vmap


class Stacked(nn.Module):
    """N networks that work at once: a layer of all is one batched matrix product.

    Attributes:
        rows: the parameters of each network, one after the other, shape (N, p).

    Args:
        members: networks that differ in nothing but the values of their parameters.
    """

    def __init__(self, members: Sequence[nn.Module]) -> None:
        super().__init__()
        # In a tuple it is no part of this module: it lends its layers, not its parameters.
        self._one = (members[0],)
        self._shapes = {name: value.shape for name, value in members[0].named_parameters()}
        vectors = [nn.utils.parameters_to_vector(member.parameters()).detach() for member in members]
        self.rows = nn.Parameter(torch.stack(vectors))

    def twin(self) -> Self:
        """A copy that nothing trains."""
        return copy.deepcopy(self).requires_grad_(False)

    def parameters_of_all(self) -> dict[str, Tensor]:
        """Views of the parameters by name, each of shape (N, …)."""
        parts = self.rows.split([shape.numel() for shape in self._shapes.values()], dim=1)
        named = zip(self._shapes.items(), parts, strict=True)
        return {name: part.reshape(len(self.rows), *shape) for (name, shape), part in named}

    def forward(self, x: Tensor) -> Tensor:
        """Results (N, …, outputs) for the inputs (N, …, inputs) of each network."""
        one = self._one[0]
        return vmap(lambda parameters, each: functional_call(one, parameters, (each,)))(self.parameters_of_all(), x)
