"""A Gaussian with full covariance, learnt through its Cholesky factor."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import torch
from scipy.special import ndtr
from torch import Tensor, nn
from torch.distributions import MultivariateNormal

from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.randomizer import Density, bin_shares
from dr_lab.trajectory import Array

# In any direction, in widths: a parameter that a fit knows exactly must not make the factor singular.
_LEAST_STD = 1e-6


class GaussianRandomizer(Density):
    """z ~ N(μ, ΛΛᵀ) with Λ lower triangular.

    φ lives in standardised units, so that one learning rate suits all parameters (as in the code released with
    Mozifian et al. 2020): μ = centre + w·loc and Λ = diag(w)·L with w = (high − low)/√12, the standard deviation of
    the uniform distribution over the bounds; L has exp(`log_diagonal`) on its diagonal and `lower` below.

    Attributes:
        loc: (n,).
        log_diagonal: (n,).
        lower: (n, n), of which only what lies below the diagonal is read.

    Args:
        space: the parameters.
        mean: SI, shape (n,).
        covariance: SI, symmetric and positive semidefinite, shape (n, n).
        clip: whether samples are moved to the nearest admissible context; `log_prob` stays that of the Gaussian.
    """

    centre: Tensor
    width: Tensor

    def __init__(self, space: ContextSpace, mean: Array, covariance: Array, clip: bool) -> None:
        super().__init__(space)
        self.clip = clip
        n = len(space.names)
        self.register_buffer("centre", torch.from_numpy((space.low + space.high) / 2))
        self.register_buffer("width", torch.from_numpy(uniform_std(space)))
        self.loc = nn.Parameter(torch.zeros(n, dtype=torch.float64))
        self.log_diagonal = nn.Parameter(torch.zeros(n, dtype=torch.float64))
        self.lower = nn.Parameter(torch.zeros(n, n, dtype=torch.float64))
        self.set_moments(mean, covariance)

    @torch.no_grad()
    def set_moments(self, mean: Array, covariance: Array) -> None:
        """Move to another mean and covariance; arguments as those of the class."""
        width = self.width.numpy()
        factor = np.linalg.cholesky(_regular(covariance / np.outer(width, width)))
        self.loc.copy_(torch.from_numpy((mean - self.centre.numpy()) / width))
        self.log_diagonal.copy_(torch.from_numpy(np.log(np.diag(factor))))
        self.lower.copy_(torch.from_numpy(np.tril(factor, -1)))

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """μ + Λε, one ε ~ N(0, I) a stream."""
        normal = self.distribution()
        width = len(self.width)
        epsilon = np.array([rng.standard_normal(width) for rng in rngs]).reshape(len(rngs), width)
        # Row by row: a product of matrices rounds otherwise for another number of streams.
        moved = (epsilon[:, None] * normal.scale_tril.detach().numpy()).sum(-1)
        z = normal.loc.detach().numpy() + moved
        return self.space.clip(z) if self.clip else z

    def log_prob(self, z: Tensor) -> Tensor:
        """−½‖Λ⁻¹(z − μ)‖² − log det Λ − n/2·log 2π."""
        return self.distribution().log_prob(z)

    def shares(self, axis: int, edges: Array) -> Array:
        """Exact; where draws are clipped, the bins at the bounds have what was moved there."""
        mean, covariance = self.moments()
        below = ndtr((edges - mean[axis]) / math.sqrt(covariance[axis, axis]))
        if self.clip:
            below = np.where(edges <= self.space.low[axis], 0.0, np.where(edges >= self.space.high[axis], 1.0, below))
        return bin_shares(below)

    def moments(self) -> tuple[Array, Array]:
        """Mean (n,) and covariance (n, n) of the Gaussian itself, in SI units, whether its draws are clipped or not."""
        normal = self.distribution()
        return normal.loc.detach().numpy().copy(), normal.covariance_matrix.detach().numpy().copy()

    def distribution(self) -> MultivariateNormal:
        """The Gaussian over z in SI units."""
        factor = torch.diag(self.log_diagonal.exp()) + self.lower.tril(-1)
        return MultivariateNormal(
            self.centre + self.width * self.loc, scale_tril=self.width[:, None] * factor, validate_args=False
        )


def _regular(covariance: Array) -> Array:
    """The covariance itself, or with the least variance in directions of less."""
    variance, direction = np.linalg.eigh(covariance)
    if variance.min(initial=np.inf) >= _LEAST_STD**2:
        return covariance
    return (direction * np.maximum(variance, _LEAST_STD**2)) @ direction.T


def uniform_std(space: ContextSpace) -> Array:
    """Standard deviations of the uniform distribution over the bounds, (high − low)/√12, shape (n,)."""
    return space.span / math.sqrt(12.0)


def centre_and_spread(
    space: ContextSpace, mean: Mapping[str, float] | None, std: Mapping[str, float] | None, relative_std: float
) -> tuple[Array, Array]:
    """Mean and standard deviation of every parameter, shape (n,) each; arguments and errors as `gaussian`."""
    given = {f"std.{name}": value for name, value in (std or {}).items()} | {"relative_std": relative_std}
    for name, value in given.items():
        if not 0.0 <= value < math.inf:
            raise ConfigError(f"randomizer.{name} is {value:g}; expected a finite standard deviation of at least 0.")
    for name, value in (mean or {}).items():
        if not math.isfinite(value):
            raise ConfigError(f"randomizer.mean.{name} is {value:g}; expected a finite number.")
    centre, spread = (space.low + space.high) / 2, relative_std * uniform_std(space)
    for name, value in (mean or {}).items():
        centre[space.index(name)] = value
    for name, value in (std or {}).items():
        spread[space.index(name)] = value
    return centre, spread


def gaussian(
    space: ContextSpace,
    mean: Mapping[str, float] | None,
    std: Mapping[str, float] | None,
    relative_std: float,
    clip: bool,
) -> GaussianRandomizer:
    """An uncorrelated Gaussian to begin with.

    Args:
        space: the parameters.
        mean: SI value by parameter; those not named take the centre of their bounds.
        std: SI standard deviation by parameter; for those not named see `relative_std`.
        relative_std: standard deviation over that of the uniform distribution over the bounds.
        clip: whether samples are moved to the nearest admissible context.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a standard deviation is negative, or a number not finite.
    """
    centre, spread = centre_and_spread(space, mean, std, relative_std)
    return GaussianRandomizer(space, centre, np.diag(spread**2), clip)
