"""Every context within given ranges is as likely as any other."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor
from torch.distributions import Independent, Uniform

from dr_lab.bounds import require_range
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Density, bin_shares
from dr_lab.trajectory import Array


class UniformBox(Independent):
    """Uniform over the box between `low` and `high`, each shape (n,)."""

    def __init__(self, low: Tensor, high: Tensor) -> None:
        super().__init__(Uniform(low, high, validate_args=False), 1, validate_args=False)
        self.low = low
        self.high = high


def box(space: ContextSpace, ranges: Mapping[str, Sequence[float]] | None) -> tuple[Tensor, Tensor]:
    """Lower and upper corner of the bounds, some of them replaced, each shape (n,).

    Args:
        space: the parameters.
        ranges: [low, high] in SI units by parameter; those not named take the space's bounds.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a range is not two finite, ordered numbers.
    """
    low, high = space.low, space.high
    for name, limits in (ranges or {}).items():
        index = space.index(name)
        require_range(limits, f"randomizer.ranges.{name}", space.parameters[index].unit)
        low[index], high[index] = limits
    return torch.from_numpy(low), torch.from_numpy(high)


class UniformRandomizer(Density):
    """p(z) = 1/∏(high − low) within a box, 0 outside: domain randomisation as it is usually done.

    Args:
        space: the parameters.
        ranges: [low, high] in SI units by parameter; those not named take the space's bounds.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a range is not two finite, ordered numbers.
    """

    low: Tensor
    high: Tensor

    def __init__(self, space: ContextSpace, ranges: Mapping[str, Sequence[float]] | None) -> None:
        super().__init__(space)
        low, high = box(space, ranges)
        self.register_buffer("low", low)
        self.register_buffer("high", high)

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """One uniform draw a stream."""
        width = len(self.low)
        unit = np.array([rng.random(width) for rng in rngs]).reshape(len(rngs), width)
        return self.low.numpy() + unit * (self.high - self.low).numpy()

    def log_prob(self, z: Tensor) -> Tensor:
        """−Σ log(high − low) within the box, −∞ outside."""
        return self.distribution().log_prob(z)

    def shares(self, axis: int, edges: Array) -> Array:
        """Exact."""
        low, high = float(self.low[axis]), float(self.high[axis])
        return bin_shares(np.clip((edges - low) / (high - low), 0.0, 1.0))

    def moments(self) -> tuple[Array, Array]:
        """(low + high) / 2 and, for each parameter, (high − low)² / 12, exact."""
        low, high = self.low.numpy(), self.high.numpy()
        return (low + high) / 2, np.diag(np.square(high - low) / 12)

    def distribution(self) -> UniformBox:
        """The box."""
        return UniformBox(self.low, self.high)
