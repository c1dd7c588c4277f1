"""Multilayer perceptrons whose gradient is also written out, because autograd costs more than small networks do."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Literal

import torch
from torch import Tensor, nn

Activation = Literal["tanh", "relu"]

_ACTIVATIONS: dict[Activation, Callable[[Tensor], Tensor]] = {"tanh": torch.tanh, "relu": torch.relu}
# Slopes as functions of the activation's own output.
_SLOPES: dict[Activation, Callable[[Tensor], Tensor]] = {
    "tanh": lambda h: 1.0 - h * h,
    "relu": lambda h: (h > 0).to(h.dtype),
}


class MLP(nn.Module):
    """h₀ = x, hₖ = σ(Wₖ hₖ₋₁ + bₖ), and a last layer without σ.

    Weights are orthogonal with gain √2 (the last layer: `last_gain`), biases 0.

    Args:
        inputs: width of x.
        hidden: widths of the hidden layers.
        outputs: width of the result.
        activation: σ.
        last_gain: gain of the last layer; small values make the first outputs small.
        generator: random numbers for the weights.
    """

    def __init__(
        self,
        inputs: int,
        hidden: Sequence[int],
        outputs: int,
        activation: Activation,
        last_gain: float,
        generator: torch.Generator,
    ) -> None:
        super().__init__()
        widths = [inputs, *hidden, outputs]
        self.weights = nn.ParameterList([torch.empty(b, a) for a, b in itertools.pairwise(widths)])
        self.biases = nn.ParameterList([torch.zeros(b) for b in widths[1:]])
        self._activate, self._slope = _ACTIVATIONS[activation], _SLOPES[activation]
        for layer, weight in enumerate(self.weights):
            gain = last_gain if layer == len(hidden) else math.sqrt(2.0)
            nn.init.orthogonal_(weight, gain, generator=generator)

    def forward(self, x: Tensor) -> Tensor:
        """Result (…, outputs) for inputs (…, inputs)."""
        return self.layers(x)[-1]

    def layers(self, x: Tensor) -> list[Tensor]:
        """x, the hidden activations and the result."""
        layers = [x]
        last = len(self.weights) - 1
        for k, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            linear = nn.functional.linear(layers[-1], weight, bias)
            layers.append(linear if k == last else self._activate(linear))
        return layers

    def backward(
        self, layers: Sequence[Tensor], slope: Tensor, weights: Sequence[Tensor], biases: Sequence[Tensor]
    ) -> None:
        """Write ∂L/∂W and ∂L/∂b by the chain rule.

        Args:
            layers: what `layers` gave for inputs (b, inputs).
            slope: ∂L/∂result, shape (b, outputs).
            weights: where the gradients by the weights go.
            biases: where those by the biases go.
        """
        for k in reversed(range(len(self.weights))):
            torch.mm(slope.t(), layers[k], out=weights[k])
            torch.sum(slope, 0, out=biases[k])
            if k:
                slope = torch.mm(slope, self.weights[k]).mul_(self._slope(layers[k]))
