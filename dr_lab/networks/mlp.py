"""Multilayer perceptrons whose gradient is also written out, because autograd costs more than small networks do."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Literal

import torch
from torch import Tensor, nn

from dr_lab.errors import ConfigError

Activation = Literal["tanh", "relu"]

_ACTIVATIONS: dict[Activation, Callable[[Tensor], Tensor]] = {"tanh": torch.tanh, "relu": torch.relu}
# Slope by what goes into the activation, from the slope by its output and the output.
_BACKWARD: dict[Activation, Callable[[Tensor, Tensor], Tensor]] = {
    "tanh": torch.ops.aten.tanh_backward.default,
    "relu": lambda slope, h: torch.ops.aten.threshold_backward.default(slope, h, 0),
}
_STEEPNESS: dict[Activation, Callable[[Tensor], Tensor]] = {
    "tanh": lambda h: torch.addcmul(h.new_ones(()), h, h, value=-1.0),
    "relu": lambda h: (h > 0).to(h.dtype),
}
_BEND: dict[Activation, Callable[[Tensor], Tensor]] = {"tanh": lambda h: -2.0 * h, "relu": torch.zeros_like}


def activated(activation: Activation, x: Tensor) -> Tensor:
    """H = σ(x)."""
    return _ACTIVATIONS[activation](x)


def steepness(activation: Activation, h: Tensor) -> Tensor:
    """The derivative σ′ where it gave h."""
    return _STEEPNESS[activation](h)


def bend(activation: Activation, h: Tensor) -> Tensor:
    """The ratio σ″/σ′ where it gave h; 0 of what has no second derivative."""
    return _BEND[activation](h)


class MLP(nn.Module):
    """h₀ = x, hₖ = σ(Wₖ hₖ₋₁ + bₖ), and a last layer without σ.

    Weights are orthogonal with gain √2 (the last layer: `last_gain`), biases 0. Where weights (N, outputs, inputs) and
    biases (N, 1, outputs) take the place of its own, it is a stack of N networks, each with inputs of its own.

    Attributes:
        names: of weight and bias of each layer.
        activation: σ.

    Args:
        inputs: width of x.
        hidden: widths of the hidden layers.
        outputs: width of the result.
        activation: σ.
        last_gain: gain of the last layer; small values make the first outputs small.
        generator: random numbers for the weights.

    Raises:
        ConfigError: a hidden layer has no width.
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
        if not all(width >= 1 for width in hidden):
            raise ConfigError(f"hidden is {list(hidden)}; expected the width of each hidden layer, at least 1, or [].")
        widths = [inputs, *hidden, outputs]
        self.names = [(f"weight{k}", f"bias{k}") for k in range(len(widths) - 1)]
        for (weight, bias), (a, b) in zip(self.names, itertools.pairwise(widths), strict=True):
            self.register_parameter(weight, nn.Parameter(torch.empty(b, a)))
            self.register_parameter(bias, nn.Parameter(torch.zeros(b)))
        self.activation: Activation = activation  # by name, as torch's operators cannot be sent to other processes
        for layer, weight in enumerate(self.weights):
            gain = last_gain if layer == len(hidden) else math.sqrt(2.0)
            nn.init.orthogonal_(weight, gain, generator=generator)

    # Looked up at every use, as TorchRL puts others in their place; a `ParameterList` takes four times as long.
    @property
    def weights(self) -> list[nn.Parameter]:
        """W₁ …, each of shape (outputs, inputs) of its layer."""
        return [getattr(self, weight) for weight, _ in self.names]

    @property
    def biases(self) -> list[nn.Parameter]:
        """b₁ …, each of shape (outputs,) of its layer."""
        return [getattr(self, bias) for _, bias in self.names]

    def forward(self, x: Tensor) -> Tensor:
        """Result (…, outputs) for inputs (…, inputs)."""
        return self.layers(x)[-1]

    def layers(self, x: Tensor) -> list[Tensor]:
        """x, the hidden activations and the result."""
        layers = [x]
        last, activate = len(self.names) - 1, _ACTIVATIONS[self.activation]
        for k, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            linear = _affine(layers[-1], weight, bias)
            layers.append(linear if k == last else activate(linear))
        return layers

    def backward(
        self, layers: Sequence[Tensor], slope: Tensor, weights: Sequence[Tensor], biases: Sequence[Tensor]
    ) -> None:
        """Write ∂L/∂W and ∂L/∂b by the chain rule.

        Args:
            layers: what `layers` gave for inputs (b, inputs); of a stack (N, b, inputs).
            slope: ∂L/∂result, shape (b, outputs); of a stack (N, b, outputs).
            weights: where the gradients by the weights go.
            biases: where those by the biases go, shape (1, width) each; of a stack (N, 1, width).
        """
        every = self.weights
        for k in reversed(range(len(every))):
            torch.matmul(slope.mT, layers[k], out=weights[k])
            torch.sum(slope, -2, keepdim=True, out=biases[k])
            if k:
                slope = self._through(k, every[k], layers, slope)

    def input_slope(self, layers: Sequence[Tensor], slope: Tensor) -> Tensor:
        """∂L/∂x, shape (b, inputs); arguments as `backward`."""
        for k, weight in reversed(list(enumerate(self.weights))):
            slope = self._through(k, weight, layers, slope)
        return slope

    def _through(self, k: int, weight: Tensor, layers: Sequence[Tensor], slope: Tensor) -> Tensor:
        """∂L by what goes into the activation that gave layer k, or by x, from ∂L by what W of the next layer gives."""
        before = torch.matmul(slope, weight)
        return _BACKWARD[self.activation](before, layers[k]) if k else before


def _affine(x: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    """W x + b; of N networks at once where W is (N, outputs, inputs), b (N, 1, outputs) and x (N, rows, inputs)."""
    if weight.dim() == 2:
        return nn.functional.linear(x, weight, bias)
    return torch.baddbmm(bias, x, weight.mT)
