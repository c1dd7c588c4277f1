"""PPO's clipped objective."""

import torch
from torch import Tensor


def clipped(ratio: Tensor, advantage: Tensor, clip: float) -> Tensor:
    """min(ρA, clip(ρ, 1 ± ε)A), in the shape of both.

    Source: Schulman et al. 2017, equation 7.
    """
    return torch.minimum(ratio * advantage, ratio.clamp(1.0 - clip, 1.0 + clip) * advantage)
