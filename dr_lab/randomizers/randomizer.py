"""The contract of a randomizer: a distribution p_φ(z) over contexts."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from torch import Tensor, nn
from torch.distributions import Distribution

from dr_lab.physics.context import ContextSpace
from dr_lab.trajectory import Array


class Randomizer(nn.Module, ABC):
    """A distribution p_φ(z) over a context space, φ being the module's parameters (none: there is nothing to learn).

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

    @abstractmethod
    def log_prob(self, z: Tensor) -> Tensor:
        """Log p_φ(z) of contexts (…, n), shape (…), differentiable in φ; a density with respect to dz in SI units."""

    def distribution(self) -> Distribution | None:
        """The same as a distribution of torch, or None where no such family exists; differentiable in φ."""
        return None
