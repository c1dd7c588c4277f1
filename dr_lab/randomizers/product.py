"""Independent groups of parameters, each with a distribution of its own family."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from torch import Tensor, nn

from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Density
from dr_lab.trajectory import Array


class ProductRandomizer(Density):
    """p(z) = ∏_k p_k(z_k), z_k being the parameters of factor k.

    Attributes:
        factors: the p_k.

    Args:
        space: the parameters.
        factors: by name, what makes a randomizer over a space.
        parameters: those of each factor, by the same names. The one factor that is not named here has all others.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a parameter has two factors or none, or not just one factor is left for all others.
    """

    def __init__(
        self,
        space: ContextSpace,
        factors: Mapping[str, Callable[[ContextSpace], Density]],
        parameters: Mapping[str, Sequence[str]],
    ) -> None:
        super().__init__(space)
        left = [name for name in factors if name not in parameters]
        given = [space.index(name) for names in parameters.values() for name in names]
        if len(left) != 1 or len(set(given)) != len(given) or not set(parameters) < set(factors):
            told = {name: list(names) for name, names in parameters.items()}
            raise ConfigError(
                f"randomizer.parameters is {told}; expected each parameter at most once, for all but one of the "
                f"factors {', '.join(factors)}. That one has the others."
            )
        rest = [i for i in range(len(space.names)) if i not in given]
        self._columns = [[space.index(name) for name in names] for names in parameters.values()] + [rest]
        makers = [factors[name] for name in [*parameters, *left]]
        self.factors = nn.ModuleList(
            [
                make(ContextSpace(tuple(space.parameters[i] for i in columns)))
                for make, columns in zip(makers, self._columns, strict=True)
            ]
        )

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """Draw from each factor in turn, with the same streams."""
        z = np.empty((len(rngs), len(self.space.names)))
        for k, columns in enumerate(self._columns):
            z[:, columns] = self._factor(k).sample(rngs)
        return z

    def log_prob(self, z: Tensor) -> Tensor:
        """Σ_k log p_k(z_k)."""
        held = [(k, columns) for k, columns in enumerate(self._columns) if columns]  # torch has no Gaussian of nothing
        return sum((self._factor(k).log_prob(z[..., columns]) for k, columns in held), z.new_zeros(z.shape[:-1]))

    def edges(self, axis: int) -> Array:
        """Those of the parameter's factor."""
        return self._place(axis)[0].edges(self._place(axis)[1])

    def shares(self, axis: int, edges: Array) -> Array:
        """Those of the parameter's factor."""
        return self._place(axis)[0].shares(self._place(axis)[1], edges)

    def _place(self, axis: int) -> tuple[Density, int]:
        """Factor of a parameter, and the parameter's place in it."""
        k = next(k for k, columns in enumerate(self._columns) if axis in columns)
        return self._factor(k), self._columns[k].index(axis)

    def _factor(self, k: int) -> Density:
        factor = self.factors[k]
        assert isinstance(factor, Density)
        return factor
