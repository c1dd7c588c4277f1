"""A piecewise constant density over a grid of cells, as a distribution of torch."""

from collections.abc import Sequence
from functools import cached_property

import torch
from torch import Tensor
from torch.distributions import Distribution, constraints
from torch.distributions.constraints import Constraint


class Histogram(Distribution):
    """p(z) = P(c)/v for z in cell c of a regular grid over [low, high], 0 outside; v is the volume of a cell.

    Args:
        low: lower corner of the grid, shape (n,).
        high: upper corner, shape (n,).
        logits: log P(c) up to a constant, one axis a dimension, shape (b₁, …, bₙ).
    """

    def __init__(self, low: Tensor, high: Tensor, logits: Tensor) -> None:
        self.low = low
        self.high = high
        self.logits = logits
        super().__init__(torch.Size(), low.shape, validate_args=False)

    @property
    def arg_constraints(self) -> dict[str, Constraint]:
        """Of the arguments that torch shows of a distribution."""
        return {"logits": constraints.real}

    @property
    def bins(self) -> Tensor:
        """Number of cells along each dimension, shape (n,)."""
        return torch.tensor(self.logits.shape, dtype=self.low.dtype)

    @property
    def cell(self) -> Tensor:
        """Edge lengths of a cell, shape (n,)."""
        return (self.high - self.low) / self.bins

    @cached_property
    def log_probabilities(self) -> Tensor:
        """Log P(c), shape (b₁, …, bₙ)."""
        return self.logits.flatten().log_softmax(0).reshape(self.logits.shape)

    @cached_property
    def centres(self) -> Tensor:
        """Middle of every cell, shape (b₁·…·bₙ, n), last dimension of the grid running fastest."""
        index = torch.cartesian_prod(*(torch.arange(b, dtype=self.low.dtype) for b in self.logits.shape))
        return self.low + (index.reshape(-1, len(self.low)) + 0.5) * self.cell

    def cell_of(self, z: Tensor) -> tuple[Tensor, ...]:
        """Index of the cell that holds each z (…, n), one tensor (…) a dimension; clamped onto the grid."""
        scaled = ((z - self.low) / self.cell).floor().long()
        last = torch.tensor(self.logits.shape) - 1
        return torch.minimum(scaled.clamp(min=0), last).unbind(-1)

    def log_prob(self, value: Tensor) -> Tensor:
        """Log P(c(z)) − log v within the grid, −∞ outside."""
        inside = ((value >= self.low) & (value <= self.high)).all(-1)
        density = self.log_probabilities[self.cell_of(value)] - self.cell.log().sum()
        return torch.where(inside, density, -torch.inf)

    def sample(self, sample_shape: Sequence[int] = ()) -> Tensor:
        """Draw a cell, then a point within it, shape (*sample_shape, n)."""
        flat = self.log_probabilities.detach().exp().flatten()
        picked = torch.multinomial(flat, torch.Size(sample_shape).numel(), replacement=True)
        inside = torch.rand(len(picked), len(self.low), dtype=self.low.dtype) - 0.5
        return (self.centres[picked] + inside * self.cell).reshape(*sample_shape, -1)

    def entropy(self) -> Tensor:
        """−Σ P log P + log v, in nats."""
        log_p = self.log_probabilities
        return -(log_p.exp() * log_p).sum() + self.cell.log().sum()

    @property
    def mean(self) -> Tensor:
        """Shape (n,)."""
        return self.log_probabilities.exp().flatten() @ self.centres

    @property
    def covariance_matrix(self) -> Tensor:
        """Between cells plus within a cell, shape (n, n)."""
        probabilities = self.log_probabilities.exp().flatten()
        deviation = self.centres - self.mean
        return (deviation * probabilities[:, None]).T @ deviation + torch.diag(self.cell**2 / 12)

    @property
    def variance(self) -> Tensor:
        """Shape (n,)."""
        return self.covariance_matrix.diagonal()
