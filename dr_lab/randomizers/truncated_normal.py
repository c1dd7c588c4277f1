"""Independent Gaussians that are cut off at the bounds."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import torch
from scipy.special import log_ndtr, ndtri_exp
from scipy.stats import truncnorm
from torch import Tensor, nn

from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.gaussian import centre_and_spread
from dr_lab.randomizers.randomizer import Density, bin_shares
from dr_lab.trajectory import Array

_LEAST_STD = 1e-6  # in widths of the bounds: an exactly known parameter has no density


class TruncatedNormalRandomizer(Density):
    """p(z) = ∏ N(z; μ, σ²) / (Φ(β) − Φ(α)) within the bounds, 0 outside; α = (low − μ)/σ, β = (high − μ)/σ.

    Attributes:
        loc: (μ − low) / (high − low), shape (n,).
        log_std: log σ / (high − low), shape (n,).

    Args:
        space: the parameters.
        mean: SI value of μ by parameter; those not named take the centre of their bounds.
        std: SI value of σ by parameter; for those not named see `relative_std`.
        relative_std: σ over the standard deviation of the uniform distribution over the bounds.

    Raises:
        UnknownNameError: a name is not a parameter.
        ConfigError: a standard deviation is negative, or a number not finite.
    """

    low: Tensor
    span: Tensor

    def __init__(
        self,
        space: ContextSpace,
        mean: Mapping[str, float] | None,
        std: Mapping[str, float] | None,
        relative_std: float,
    ) -> None:
        super().__init__(space)
        centre, spread = centre_and_spread(space, mean, std, relative_std)
        self.register_buffer("low", torch.from_numpy(space.low))
        self.register_buffer("span", torch.from_numpy(space.span))
        self.loc = nn.Parameter(torch.from_numpy(space.to_unit(centre)))
        self.log_std = nn.Parameter(torch.from_numpy(np.log(np.maximum(spread / space.span, _LEAST_STD))))

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        """One draw a stream by the inverse of the distribution function, in its smaller tail and by its logarithm."""
        width = len(self.low)
        uniform = np.array([rng.random(width) for rng in rngs]).reshape(len(rngs), width)
        loc, std = self.loc.detach().numpy(), self.log_std.detach().exp().numpy()
        first, last = -loc / std, (1.0 - loc) / std
        right = first + last > 0  # mirrored, so that the interval lies on the left, where Φ is exact
        low, high = np.where(right, -last, first), np.where(right, -first, last)
        with np.errstate(divide="ignore"):  # log 0 = −∞ is meant
            share = np.logaddexp(log_ndtr(low) + np.log1p(-uniform), log_ndtr(high) + np.log(uniform))
        standard = np.clip(ndtri_exp(share), low, high)
        unit = loc + std * np.where(right, -standard, standard)
        return self.space.clip(self.space.from_unit(unit))

    def log_prob(self, z: Tensor) -> Tensor:
        """Σ −½((z − μ)/σ)² − log σ − ½ log 2π − log(Φ(β) − Φ(α)) within the bounds, −∞ outside."""
        unit, std = (z - self.low) / self.span, self.log_std.exp()
        first, last = -self.loc / std, (1.0 - self.loc) / std
        right = first + last > 0
        below = torch.special.log_ndtr(torch.where(right, -last, first))
        above = torch.special.log_ndtr(torch.where(right, -first, last))
        mass = above + torch.log1p(-(below - above).exp())
        standard = (unit - self.loc) / std
        density = -standard.square() / 2 - self.log_std - math.log(2 * math.pi) / 2 - mass - self.span.log()
        inside = ((unit >= 0) & (unit <= 1)).all(-1)
        return torch.where(inside, density.sum(-1), -torch.inf)

    def shares(self, axis: int, edges: Array) -> Array:
        """Exact."""
        loc, std = float(self.loc[axis].detach()), float(self.log_std[axis].detach().exp())
        unit = (edges - float(self.low[axis])) / float(self.span[axis])
        return bin_shares(truncnorm.cdf(unit, -loc / std, (1.0 - loc) / std, loc=loc, scale=std))

    def edges(self, axis: int) -> Array:
        """Within the bounds, beyond which nothing lies."""
        edges = super().edges(axis)
        return edges[(edges >= self.space.low[axis]) & (edges <= self.space.high[axis])]
