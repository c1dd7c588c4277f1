"""Both ends of the spectrum of a Hessian that is known by its products with vectors alone."""

from collections.abc import Callable

import numpy as np
import torch
from scipy.sparse.linalg import LinearOperator, eigsh
from torch import Tensor
from torch.func import grad

from dr_lab.trajectory import Array

Product = Callable[[Array], Array]
"""v ↦ H v, shape (p,) each."""


def hessian_product(loss: Callable[[Tensor], Tensor], at: Tensor) -> Product:
    """The map v ↦ ∇²L(θ)·v = ∇(∇L(θ)·v), which costs a few gradients (Pearlmutter 1994).

    Args:
        loss: L, from parameters (p,) to a scalar; a pure function.
        at: θ.
    """
    slope = grad(loss)

    def product(vector: Array) -> Array:
        along = torch.from_numpy(np.ascontiguousarray(vector.reshape(-1))).to(at)
        return grad(lambda moved: slope(moved) @ along)(at).detach().double().numpy()

    return product


def curvatures(losses: Callable[[Tensor], Tensor], at: Tensor, along: Array) -> Array:
    """d²L_i(θ + s v)/ds² at s = 0 of k losses at once, shape (k,): the gradient by w of that of Σ_i w_i L_i.

    Args:
        losses: L, from parameters (p,) to (k,); a pure function.
        at: θ.
        along: v, shape (p,).
    """
    direction, zero = torch.from_numpy(along).to(at), torch.zeros((), dtype=at.dtype)

    def weighted(distance: Tensor, weights: Tensor) -> Tensor:
        return losses(at + distance * direction) @ weights

    second = grad(lambda weights: grad(grad(weighted))(zero, weights))
    with torch.no_grad():
        equal = torch.ones_like(losses(at))
    return second(equal).detach().double().numpy()


def ends_of_spectrum(product: Product, size: int, count: int, seed: int) -> tuple[Array, Array]:
    """The largest and the smallest eigenvalues of a symmetric matrix, by Lanczos' method.

    Args:
        product: the matrix, of shape (p, p).
        size: p.
        count: eigenvalues at each end; all are given where there are not that many.
        seed: of the vector that it begins with.

    Returns:
        Eigenvalues, descending, shape (m,), and eigenvectors of length 1, shape (m, p); m = min(2·count, p).
    """
    if 2 * count >= size:
        values, vectors = np.linalg.eigh(np.array([product(row) for row in np.eye(size)]))
    else:
        matrix = LinearOperator((size, size), matvec=product, dtype=np.float64)  # pyright: ignore[reportCallIssue]
        begin = np.random.default_rng(seed).normal(size=size)
        values, vectors = eigsh(matrix, k=2 * count, which="BE", v0=begin)
    order = np.argsort(values)[::-1]
    return values[order], vectors.T[order]
