"""One context, always."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor

from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Density
from dr_lab.trajectory import Array


class FixedRandomizer(Density):
    """All mass at one context: no randomisation.

    `log_prob` is a log-mass, not a density: 0 at that context and −∞ elsewhere.

    Args:
        space: the parameters.
        values: SI value by parameter; those not named are nominal.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a value is not finite.
    """

    z: Tensor

    def __init__(self, space: ContextSpace, values: Mapping[str, float] | None) -> None:
        super().__init__(space)
        self.register_buffer("z", torch.from_numpy(space.vector(values or {})))

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """The context, once for each stream."""
        return np.tile(self.z.numpy(), (len(rngs), 1))

    def log_prob(self, z: Tensor) -> Tensor:
        """0 at the context, −∞ elsewhere."""
        return torch.where((z == self.z).all(-1), 0.0, -torch.inf).to(self.z.dtype)
