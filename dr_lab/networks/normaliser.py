"""What a policy does to observations before its network sees them; saved with the policy."""

from abc import ABC, abstractmethod

import torch
from torch import Tensor, nn

from dr_lab.bounds import Limit, require_bounds


class Normaliser(nn.Module, ABC):
    """A fixed map of observations (…, o), whose statistics are renewed between batches.

    Args:
        size: o.
    """

    @abstractmethod
    def update(self, observation: Tensor) -> None:
        """Take a batch (…, o) into the statistics."""


class NoNormaliser(Normaliser):
    """Observations as they are."""

    def __init__(self, size: int) -> None:
        del size
        super().__init__()

    def forward(self, observation: Tensor) -> Tensor:
        """The observation itself."""
        return observation

    def update(self, observation: Tensor) -> None:
        """Nothing."""
        del observation


class RunningNormaliser(Normaliser):
    """(o − mean)/std over everything seen so far, cut at ±clip.

    Args:
        size: o.
        clip: largest absolute value, in standard deviations.

    Raises:
        ConfigError: it is not above 0.
    """

    count: Tensor
    mean: Tensor
    variance: Tensor
    shift: Tensor
    scale: Tensor

    def __init__(self, size: int, clip: Limit) -> None:
        super().__init__()
        self.clip = clip
        require_bounds(self, "algorithm.actor.normaliser", RunningNormaliser)
        self.register_buffer("count", torch.zeros((), dtype=torch.float64))
        self.register_buffer("mean", torch.zeros(size, dtype=torch.float64))
        self.register_buffer("variance", torch.ones(size, dtype=torch.float64))
        self.register_buffer("shift", torch.zeros(size))
        self.register_buffer("scale", torch.ones(size))

    def forward(self, observation: Tensor) -> Tensor:
        """Normalised observations, shape (…, o)."""
        return ((observation - self.shift) * self.scale).clamp_(-self.clip, self.clip)

    def update(self, observation: Tensor) -> None:
        """Merge a batch's mean and variance (Chan et al. 1979)."""
        rows = observation.reshape(-1, observation.shape[-1]).double()
        variance, mean = torch.var_mean(rows, 0, correction=0)
        total = self.count + len(rows)
        share = len(rows) / total
        gap = mean - self.mean
        self.mean += gap * share
        self.variance.copy_(self.variance * (1 - share) + variance * share + gap**2 * share * (1 - share))
        self.count.copy_(total)
        self.shift.copy_(self.mean)
        self.scale.copy_((self.variance + 1e-8).rsqrt())  # 1e-8: an observation that never changes
