"""The direction in which particles climb together and keep apart."""

import math
from typing import NamedTuple

import torch
from torch import Tensor


class Kernel(NamedTuple):
    """A kernel k between n particles, and how it pushes them apart.

    Attributes:
        values: k(xⱼ, xᵢ), shape (n, n).
        repulsion: Σⱼ ∇_{xⱼ} k(xⱼ, xᵢ) of particle i, shape (n, p).
    """

    values: Tensor
    repulsion: Tensor


def rbf(x: Tensor) -> Kernel:
    """k(x, y) = exp(−‖x − y‖²/h), where h = median ‖xⱼ − xᵢ‖² / ln(n + 1) over the pairs counts as a constant.

    With this h the kernels of one particle with the others sum to about 1, which is its own with itself (Liu and Wang
    2016, §5). ∇ₓ k(x, y) = −(2/h)(x − y) k(x, y), so that Σⱼ ∇_{xⱼ} k(xⱼ, xᵢ) = (2/h) Σⱼ k(xⱼ, xᵢ)(xᵢ − xⱼ).

    Args:
        x: particles, shape (n, p).
    """
    n = len(x)
    square = torch.cdist(x, x, compute_mode="donot_use_mm_for_euclid_dist").square()
    pairs = square[tuple(torch.triu_indices(n, n, offset=1))]
    h = pairs.median() / math.log(n + 1) if n > 1 else square.new_ones(())
    h = h.clamp(min=torch.finfo(x.dtype).tiny)  # of particles that coincide
    values = (-square / h).exp()
    return Kernel(values, (2.0 / h) * (values.sum(0)[:, None] * x - values.T @ x))


def ascent_direction(x: Tensor, gradient: Tensor, temperature: float) -> Tensor:
    """φ(xᵢ) = (1/n) Σⱼ [k(xⱼ, xᵢ) ∇J(xⱼ)/T + ∇_{xⱼ} k(xⱼ, xᵢ)].

    Steps along φ lower the divergence of the particles from q(x) ∝ exp(J(x)/T): with T → 0 all climb to maxima of J,
    with T → ∞ they only spread.

    Source: Liu, Ramachandran, Liu, Peng: Stein Variational Policy Gradient, 2017, equation 8.

    Args:
        x: particles, shape (n, p).
        gradient: ∇J of each, shape (n, p).
        temperature: T.
    """
    kernel = rbf(x)
    return (kernel.values.T @ gradient / temperature + kernel.repulsion) / len(x)
