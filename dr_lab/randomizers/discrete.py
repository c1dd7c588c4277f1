"""A grid of cells with a probability each, uniform within a cell."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor, nn

from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.histogram import Histogram
from dr_lab.randomizers.randomizer import Density, bin_shares
from dr_lab.randomizers.uniform import box
from dr_lab.trajectory import Array

_MOST_CELLS = 1_000_000  # a joint grid grows as binsⁿ


class DiscreteRandomizer(Density):
    """z lies in cell c with probability softmax(logits)_c, uniform within it; uniform over the ranges to begin with.

    The grid is joint: n parameters have binsⁿ cells, so correlations can be learnt.

    Attributes:
        logits: φ, one axis a parameter, shape (bins, …, bins).

    Args:
        space: the parameters.
        ranges: [low, high] in SI units by parameter; those not named take the space's bounds.
        bins: cells along each parameter.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a range is not ordered, or the grid has too many cells.
    """

    low: Tensor
    high: Tensor

    def __init__(self, space: ContextSpace, ranges: Mapping[str, Sequence[float]] | None, bins: int) -> None:
        super().__init__(space)
        n = len(space.names)
        if n == 0:
            raise ConfigError(
                "randomizer=discrete has no cells: the machine varies no parameter. Choose some, e.g. "
                "env/context=hopper/torso_size, or take randomizer=fixed."
            )
        if bins < 1 or bins**n > _MOST_CELLS:
            raise ConfigError(
                f"randomizer.bins is {bins}: {n} parameters make {bins**n:g} cells; expected 1 to {_MOST_CELLS:g}. "
                "Take fewer bins, free fewer parameters, or take randomizer=gaussian."
            )
        low, high = box(space, ranges)
        self.register_buffer("low", low)
        self.register_buffer("high", high)
        self.logits = nn.Parameter(torch.zeros((bins,) * n, dtype=torch.float64))
        self._known: tuple[Tensor, Array] | None = None  # logits, and what `_cumulated` made of them

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """One cell a stream by the inverse of the cumulated probabilities, then a point within it."""
        width = 1 + len(self.low)
        unit = np.array([rng.random(width) for rng in rngs]).reshape(len(rngs), width)
        cumulated = self._cumulated()
        picked = np.searchsorted(cumulated, unit[:, 0] * cumulated[-1], side="right")
        index = np.stack(np.unravel_index(picked, self.logits.shape), axis=-1)
        return self.low.numpy() + (index + unit[:, 1:]) * self.distribution().cell.numpy()

    def log_prob(self, z: Tensor) -> Tensor:
        """Log softmax(logits)_c − log v within the grid, −∞ outside; v is the volume of a cell."""
        return self.distribution().log_prob(z)

    def edges(self, axis: int) -> Array:
        """Those of the cells, where these fill just the bounds."""
        if not self._fills(axis):
            return super().edges(axis)
        return np.linspace(self.space.low[axis], self.space.high[axis], self.logits.shape[axis] + 1)

    def shares(self, axis: int, edges: Array) -> Array:
        """Exact: the distribution function is linear within a cell."""
        probabilities = self.distribution().log_probabilities.detach().exp()
        others = [k for k in range(probabilities.ndim) if k != axis]
        cells = (torch.sum(probabilities, others) if others else probabilities).numpy()
        ends = np.linspace(float(self.low[axis]), float(self.high[axis]), len(cells) + 1)
        return bin_shares(np.interp(edges, ends, np.concatenate([[0.0], np.cumsum(cells)])))

    def _cumulated(self) -> Array:
        """Probability of each cell and those before it, shape (cells,); a million take 20 ms to work out."""
        logits = self.logits.detach()
        if self._known is None or not torch.equal(self._known[0], logits):
            probabilities = self.distribution().log_probabilities.detach().exp()
            self._known = logits.clone(), probabilities.flatten().cumsum(0).numpy()
        return self._known[1]

    def _fills(self, axis: int) -> bool:
        return (self.low[axis], self.high[axis]) == (self.space.low[axis], self.space.high[axis])

    def distribution(self) -> Histogram:
        """The grid."""
        return Histogram(self.low, self.high, self.logits)
