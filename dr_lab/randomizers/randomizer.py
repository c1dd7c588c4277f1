"""The contracts of a randomizer: what contexts are drawn from, and that with a density."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.distributions import Distribution

from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import UNKEYED, Proposals
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_BINS = 60  # of a picture over the bounds; as many are on either side of them
_DRAWS = 4000  # from the same stream each time, so that a picture moves only where the distribution does


class Randomizer(nn.Module, ABC):
    """What contexts are drawn from, φ being the module's parameters (none: there is nothing to learn).

    z has the parameters' SI units, shape (n,), float64. Samples may lie outside of the space's bounds, where a
    distribution has unbounded support; what such a context means is the environment's business.

    Attributes:
        space: the parameters that z holds.
    """

    def __init__(self, space: ContextSpace) -> None:
        super().__init__()
        self.space = space

    @abstractmethod
    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """One draw from each stream, shape (len(rngs), n); what one stream gives does not depend on the others."""

    def propose(self, rngs: Sequence[np.random.Generator], slots: NDArray[np.intp]) -> Proposals:
        """Draws, alike in every slot and without keys unless said otherwise."""
        del slots
        return Proposals(self.sample(rngs), np.full(len(rngs), UNKEYED, np.int64))

    def edges(self, axis: int) -> Array:
        """Edges of the bins in which pictures show a parameter, shape (b + 1,), the bounds among them.

        They reach as far beyond the bounds as these are wide, unless nothing can lie there.
        """
        low, high = self.space.low[axis], self.space.high[axis]
        below, above = 2 * low - high, 2 * high - low
        parts = [np.linspace(*ends, _BINS, endpoint=False) for ends in ((below, low), (low, high), (high, above))]
        return np.concatenate([*parts, [above]])

    def marginal(self, axis: int) -> Array:
        """Probability of each of these bins of a parameter, shape (b,)."""
        return self.shares(axis, self.edges(axis))

    def shares(self, axis: int, edges: Array) -> Array:
        """Probability of each bin between any `edges`, from draws unless it is known; the outermost hold all beyond."""
        draws, high = self._draws()[:, axis], self.space.high[axis]
        inside = np.where(draws == high, np.nextafter(high, -np.inf), draws)  # bins are open above
        return np.histogram(np.clip(inside, edges[0], edges[-1]), edges)[0] / len(draws)  # what is beyond: in the last

    def moments(self) -> tuple[Array, Array] | None:
        """Mean (n,) and covariance (n, n), from draws; None where they say nothing, as of particles."""
        z = self._draws()
        return z.mean(0), np.atleast_2d(np.cov(z.T))

    def _draws(self) -> Array:
        return self.sample([stream(0, "snapshot")] * _DRAWS)


def shared_edges(parts: Sequence[Randomizer], axis: int) -> Array | None:
    """Edges of the bins in which pictures show a parameter, where they are those of all parts of a distribution."""
    first, *others = (part.edges(axis) for part in parts)
    return first if all(np.array_equal(first, other) for other in others) else None


def bin_shares(below: Array) -> Array:
    """Probability of each bin, shape (b,), from the distribution function at its edges; the outermost hold all beyond.

    Args:
        below: probability of a lower value, at each edge, shape (b + 1,).
    """
    return np.diff(np.concatenate([[0.0], below[1:-1], [1.0]]))


class Density(Randomizer):
    """A randomizer that knows how likely a context is: a distribution p_φ(z)."""

    @abstractmethod
    def log_prob(self, z: Tensor) -> Tensor:
        """Log p_φ(z) of contexts (…, n), shape (…), differentiable in φ; a density with respect to dz in SI units."""

    def distribution(self) -> Distribution | None:
        """The same as a distribution of torch, or None where no such family exists; differentiable in φ."""
        return None
