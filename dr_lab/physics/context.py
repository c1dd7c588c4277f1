"""The context z: the ordered vector of a model's simulation parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class ContextSpace:
    """Names, bounds and units of a context z, shape (n,).

    Attributes:
        parameters: the parameters, in the order of the vector.
    """

    parameters: tuple[Parameter, ...]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Parameter names, length n."""
        return tuple(p.name for p in self.parameters)

    @property
    def nominal(self) -> Array:
        """Nominal values, shape (n,)."""
        return np.array([p.nominal for p in self.parameters], dtype=float)

    @property
    def low(self) -> Array:
        """Lower bounds, shape (n,)."""
        return np.array([p.low for p in self.parameters], dtype=float)

    @property
    def high(self) -> Array:
        """Upper bounds, shape (n,)."""
        return np.array([p.high for p in self.parameters], dtype=float)

    @property
    def span(self) -> Array:
        """Widths of the bounds, shape (n,)."""
        return self.high - self.low

    def to_unit(self, z: Array) -> Array:
        """Map values onto the unit cube: u = (z − low)/(high − low); shapes (…, n)."""
        return (z - self.low) / self.span

    def from_unit(self, u: Array) -> Array:
        """Inverse of `to_unit`."""
        return self.low + u * self.span

    def clip(self, z: Array) -> Array:
        """Nearest admissible context."""
        return np.clip(z, self.low, self.high)

    def vector(self, values: Mapping[str, float]) -> Array:
        """Context with the named values set and the others nominal, shape (n,).

        Raises:
            UnknownNameError: a name is not a parameter of this space.
            ConfigError: a value is not finite.
        """
        z = self.nominal
        for name, value in values.items():
            index = self.index(name)
            if not np.isfinite(value):
                raise ConfigError(
                    f"Parameter {name} of the context is {value:g}; expected a finite number. Its bounds are "
                    f"{self.low[index]:g} to {self.high[index]:g}."
                )
            z[index] = value
        return z

    def mapping(self, z: Array) -> dict[str, float]:
        """The vector z as name → value."""
        return dict(zip(self.names, (float(v) for v in z), strict=True))

    def index(self, name: str) -> int:
        """Position of a parameter in the vector.

        Raises:
            UnknownNameError: there is no such parameter.
        """
        if name not in self.names:
            raise UnknownNameError("parameter", name, self.names, "the context")
        return self.names.index(name)


@dataclass(frozen=True)
class ContextEstimate:
    """What a fit knows about a context: a Gaussian with bounds.

    Attributes:
        space: the parameters.
        mean: estimated values, shape (n,).
        covariance: covariance of the estimate, shape (n, n).
    """

    space: ContextSpace
    mean: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviation of each value, shape (n,)."""
        return np.sqrt(np.clip(np.diag(self.covariance), 0.0, None))

    def table(self) -> dict[str, dict[str, float | str]]:
        """Name → value, std and unit, as `report.json` stores it."""
        return {
            p.name: {"value": float(v), "std": float(s), "unit": p.unit}
            for p, v, s in zip(self.space.parameters, self.mean, self.std, strict=True)
        }


def concatenate(spaces: Sequence[ContextSpace]) -> ContextSpace:
    """One space of all parameters, in order."""
    return ContextSpace(tuple(p for space in spaces for p in space.parameters))
