"""Conjugate gradients for a matrix that is known by its products with vectors alone."""

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

Product = Callable[[Tensor], Tensor]
"""v ↦ H v, shape (p,) each."""


class Solved(NamedTuple):
    """What was found.

    Attributes:
        found: x, shape (p,).
        image: H x.
    """

    found: Tensor
    image: Tensor


def conjugate_gradients(product: Product, wanted: Tensor, iterations: int, tolerance: float) -> Solved:
    """Solve H x = b: nearly, and in exact arithmetic exactly after p iterations.

    Source: Hestenes, Stiefel 1952.

    Args:
        product: H, symmetric and positive definite.
        wanted: b, shape (p,).
        iterations: products at most.
        tolerance: of |b − H x|/|b|, at which it ends before.

    Returns:
        X and H x; where a direction is met along which H is not positive, what was found before it.
    """
    found, residual = torch.zeros_like(wanted), wanted.clone()
    direction, square = wanted.clone(), float(wanted @ wanted)
    least = tolerance**2 * square
    for _ in range(iterations):
        if square <= least:
            break
        image = product(direction)
        curvature = float(direction @ image)
        if not curvature > 0.0:
            break
        found += square / curvature * direction
        residual -= square / curvature * image
        before, square = square, float(residual @ residual)
        direction = residual + square / before * direction
    return Solved(found, wanted - residual)
