"""Many networks in the vicinity of their parameters, with derivatives of first and second order written out."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import torch
from torch import Tensor

from dr_lab.networks.mlp import MLP, Activation, activated, bend, steepness


class Slopes(NamedTuple):
    """How a scalar changes with what goes into the layers.

    Attributes:
        linear: e_k, by W_k h_{k−1} + b_k, of every layer, shape (N, rows, width).
        bends: by h_k, times σ″/σ′ at it, of every hidden layer.
    """

    linear: Sequence[Tensor]
    bends: Sequence[Tensor]


class LinearisedMLP:
    """N networks of one architecture, each on rows of its own: what autograd does, without a graph.

    Nothing is followed back through it. Parameters, gradients and directions are mappings as `MLP.named_parameters`
    names them, of shape (N, …).

    Args:
        body: the architecture.
        parameters: of the networks.
        x: inputs, shape (N, rows, inputs).
    """

    def __init__(self, body: MLP, parameters: Mapping[str, Tensor], x: Tensor) -> None:
        self._names = body.names
        self._activation: Activation = body.activation
        self._weights = [parameters[weight] for weight, _ in self._names]
        self._layers, self._steep = [x], list[Tensor]()
        for k, (weight, (_, bias)) in enumerate(zip(self._weights, self._names, strict=True)):
            linear = torch.baddbmm(parameters[bias].unsqueeze(1), self._layers[-1], weight.mT)
            last = k == len(self._names) - 1
            self._layers.append(linear if last else activated(self._activation, linear))
            if not last:
                self._steep.append(steepness(self._activation, self._layers[-1]))

    @property
    def output(self) -> Tensor:
        """What the networks give, shape (N, rows, outputs)."""
        return self._layers[-1]

    def tangents(self, direction: Mapping[str, Tensor]) -> list[Tensor]:
        """How all layers change along a direction of the parameters, the output last: dh_k, k ≥ 1."""
        found = list[Tensor]()
        for k, (weight, bias) in enumerate(self._names):
            moved = torch.baddbmm(direction[bias].unsqueeze(1), self._layers[k], direction[weight].mT)
            if found:
                moved.baddbmm_(found[-1], self._weights[k].mT)
            found.append(moved if k == len(self._steep) else moved.mul_(self._steep[k]))
        return found

    def slopes(self, slope: Tensor) -> Slopes:
        """How a scalar changes with all layers, from how it does with the output, shape (N, rows, outputs)."""
        linear, bends = [slope], list[Tensor]()
        for k in reversed(range(len(self._steep))):
            by_hidden = torch.bmm(linear[-1], self._weights[k + 1])
            linear.append(by_hidden * self._steep[k])
            bends.append(by_hidden.mul_(bend(self._activation, self._layers[k + 1])))
        return Slopes(linear[::-1], bends[::-1])

    def gradient(self, slopes: Slopes) -> dict[str, Tensor]:
        """How it changes with the parameters."""
        return self._by_parameters(slopes.linear)

    def gradient_along(
        self, slopes: Slopes, direction: Mapping[str, Tensor], tangents: Sequence[Tensor], change: Tensor
    ) -> dict[str, Tensor]:
        """How `gradient` changes along a direction: a product with a Hessian.

        Args:
            slopes: of the scalar.
            direction: of the parameters.
            tangents: along it.
            change: of the slope by the output along it, shape (N, rows, outputs).
        """
        changes = [change]
        for k in reversed(range(len(self._steep))):
            moved = torch.bmm(slopes.linear[k + 1], direction[self._names[k + 1][0]])
            moved.baddbmm_(changes[-1], self._weights[k + 1]).mul_(self._steep[k])
            changes.append(moved.addcmul_(slopes.bends[k], tangents[k]))
        found = self._by_parameters(changes[::-1])
        for k in range(1, len(self._names)):
            found[self._names[k][0]].baddbmm_(slopes.linear[k].mT, tangents[k - 1])
        return found

    def _by_parameters(self, linear: Sequence[Tensor]) -> dict[str, Tensor]:
        found = dict[str, Tensor]()
        for (weight, bias), before, slope in zip(self._names, self._layers[:-1], linear, strict=True):
            found[weight], found[bias] = torch.bmm(slope.mT, before), slope.sum(1)
        return found
