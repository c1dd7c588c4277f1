"""What a stochastic policy gives for an observation: a Gaussian over actions."""

import math
from typing import NamedTuple

from torch import Tensor

_LOG_2_PI = math.log(2.0 * math.pi)


class Gaussian(NamedTuple):
    """N(μ, diag σ²) over actions scaled to ±1.

    Attributes:
        mean: μ, shape (…, nu).
        log_std: log σ, shape (nu,), or any that broadcasts against the mean.
    """

    mean: Tensor
    log_std: Tensor

    def sample(self, noise: Tensor) -> Tensor:
        """μ + σ·noise, where the noise (…, nu) is drawn from N(0, 1)."""
        return self.mean + self.log_std.exp() * noise

    def log_prob(self, unit: Tensor) -> Tensor:
        """Log-density at actions (…, nu), shape (…)."""
        z = (unit - self.mean) * (-self.log_std).exp()
        return -0.5 * (z * z).sum(-1) - self.log_std.sum(-1) - 0.5 * self.mean.shape[-1] * _LOG_2_PI

    def entropy(self) -> Tensor:
        """Entropy in nats, shape of `log_std` without its last dimension."""
        return self.log_std.sum(-1) + 0.5 * self.log_std.shape[-1] * (1.0 + _LOG_2_PI)


def divergence(of: Gaussian, to: Gaussian) -> Tensor:
    """KL(of ‖ to) = Σ [log σ₂ − log σ₁ + (σ₁² + (μ₁ − μ₂)²)/(2σ₂²) − ½] in nats, shape of the means without the last.

    Args:
        of: with μ₁ and σ₁.
        to: with μ₂ and σ₂.
    """
    gap = to.log_std - of.log_std
    square = (of.mean - to.mean).square() * (-2.0 * to.log_std).exp()
    return (gap + 0.5 * ((-2.0 * gap).exp() + square - 1.0)).sum(-1)
