"""A weighted sum of other randomizers."""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import torch
from torch import Tensor, nn

from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Density, shared_edges
from dr_lab.trajectory import Array


class MixtureRandomizer(Density):
    """p(z) = Σ_k w_k p_k(z) with w = softmax(logits).

    Attributes:
        logits: log-weights, learnt like the components' own parameters, shape (k,).
        components: the p_k.

    Args:
        space: the parameters.
        components: by name, what makes a randomizer over a space.
        weights: positive weight of each, by the same names; they need not add up to 1.

    Raises:
        ConfigError: the names of components and weights differ, or a weight is not positive and finite.
    """

    def __init__(
        self,
        space: ContextSpace,
        components: Mapping[str, Callable[[ContextSpace], Density]],
        weights: Mapping[str, float],
    ) -> None:
        super().__init__(space)
        if not components or set(components) != set(weights) or not all(0.0 < w < math.inf for w in weights.values()):
            raise ConfigError(
                f"randomizer.weights is {dict(weights)}; expected a finite number above 0 for each of the components "
                f"{', '.join(components) or '(none given)'}."
            )
        self.components = nn.ModuleList([make(space) for make in components.values()])
        self.logits = nn.Parameter(torch.tensor([weights[name] for name in components], dtype=torch.float64).log())

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """Pick a component by the stream's first number, then draw from it with the same stream."""
        cumulated = self.logits.detach().softmax(0).cumsum(0).numpy()
        picked = np.searchsorted(cumulated, [rng.random() * cumulated[-1] for rng in rngs], side="right")
        z = np.empty((len(rngs), len(self.space.names)))
        for k in range(len(self.components)):
            mine = [i for i, choice in enumerate(picked) if choice == k]
            z[mine] = self._component(k).sample([rngs[i] for i in mine])
        return z

    def log_prob(self, z: Tensor) -> Tensor:
        """Log Σ_k w_k p_k(z)."""
        parts = [self._component(k).log_prob(z) for k in range(len(self.components))]
        return (torch.stack(parts, -1) + self.logits.log_softmax(0)).logsumexp(-1)

    def edges(self, axis: int) -> Array:
        """Those of the components where they are the same."""
        found = shared_edges([self._component(k) for k in range(len(self.components))], axis)
        return super().edges(axis) if found is None else found

    def shares(self, axis: int, edges: Array) -> Array:
        """Those of the components by their weights."""
        each = [self._component(k).shares(axis, edges) for k in range(len(self.components))]
        return self.logits.detach().softmax(0).numpy() @ np.array(each)

    def _component(self, k: int) -> Density:
        component = self.components[k]
        assert isinstance(component, Density)
        return component
