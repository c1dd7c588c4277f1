"""Cosines between the mean gradients of contexts, with what noise does to them taken off."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array

_BATCH = 100  # resamples at a time, which bounds the memory that they take
_SPLITS = 200  # of a context's episodes in halves


@dataclass(frozen=True)
class Cosines:
    """n contexts, compared two by two; NaN where a context has fewer than two episodes.

    Attributes:
        raw: cosine of the mean gradients ḡ, shape (n, n), which noise draws to 0. How far, the diagonal says: the
            cosine with the mean gradient of as many other episodes of the same context.
        corrected: cosine of the gradients ∇J themselves, shape (n, n), 1 on the diagonal. NaN where a gradient is not
            told from noise. By what noise is left it may lie beyond ±1.
        low: lower end of its interval, NaN on the diagonal.
        high: upper end of it.
        sign: −1 where the interval of ⟨∇J_a, ∇J_b⟩ lies below 0, +1 where above, 0 where the sign is in doubt; on the
            diagonal 1 where the gradient is told from noise.
    """

    raw: Array
    corrected: Array
    low: Array
    high: Array
    sign: NDArray[np.intp]


def cosines(gradients: Sequence[Array], confidence: float, resamples: int, seed: int) -> Cosines:
    """Compare contexts by the gradients of their episodes.

    The diagonal of `raw` is 2r/(1 + r), r being the mean cosine between random halves of the episodes (Spearman 1910,
    Brown 1910). Of noise alone r may lie below −1/3, where that is no cosine any more and −1 stands. For `corrected`,
    ⟨∇J_a, ∇J_b⟩ is ⟨ḡ_a, ḡ_b⟩ for a ≠ b, and ‖∇J_a‖² the mean of ⟨g_i, g_j⟩ over all pairs of different episodes, both
    without bias. Intervals are percentiles of a bootstrap over the episodes of every context, in which an episode that
    was drawn twice is no pair with itself.

    Args:
        gradients: of the episodes of each context, independent of one another, shape (k, p) each.
        confidence: of the intervals, below 1.
        resamples: of the bootstrap.
        seed: of the bootstrap and the halves.
    """
    kept = [len(each) >= 2 for each in gradients]
    known = [each for each, enough in zip(gradients, kept, strict=True) if enough]
    n, place = len(gradients), np.ix_(*[np.flatnonzero(kept)] * 2)
    raw, corrected, low, high = (np.full((n, n), np.nan) for _ in range(4))
    sign = np.zeros((n, n), np.intp)
    if known:
        sizes, episodes = np.array([len(each) for each in known]), np.concatenate(known)
        products, rng = episodes @ episodes.T, np.random.default_rng(seed)
        raw[place] = _raw(products, sizes, rng)
        found = _corrected(products, sizes, rng, (resamples, (1.0 - confidence) / 2.0))
        for whole, part in zip((corrected, low, high, sign), found, strict=True):
            whole[place] = part
    return Cosines(raw, corrected, low, high, sign)


def _raw(products: Array, sizes: NDArray[np.intp], rng: np.random.Generator) -> Array:
    """Cosines of the mean gradients, and of halves on the diagonal.

    Args:
        products: inner product of every two episodes, shape (k, k).
        sizes: episodes of each context, shape (n,).
        rng: of the halves.
    """
    first = _first(sizes)
    sums = np.add.reduceat(np.add.reduceat(products, first, axis=0), first, axis=1)
    result = _cosine(sums, np.diagonal(sums)[:, None], np.diagonal(sums))
    for a, (begin, size) in enumerate(zip(first, sizes, strict=True)):
        own = products[begin : begin + size, begin : begin + size]
        order = rng.permuted(np.tile(np.arange(size), (_SPLITS, 1)), axis=1)
        halves = [np.eye(size)[order[:, part : 2 * (size // 2) : 2]].sum(1) for part in (0, 1)]
        one, other, both = (((halves[i] @ own) * halves[j]).sum(1) for i, j in ((0, 0), (1, 1), (0, 1)))
        r = np.mean(_cosine(both, one, other))
        result[a, a] = max(2.0 * r / (1.0 + r), -1.0) if r > -1.0 else np.nan
    return result


def _corrected(
    products: Array, sizes: NDArray[np.intp], rng: np.random.Generator, bootstrap: tuple[int, float]
) -> tuple[Array, Array, Array, NDArray[np.intp]]:
    """Cosines without noise, the ends of their intervals, and signs, shape (n, n) each.

    Args:
        products: as `_raw` takes them, as all that follows.
        sizes: of the contexts.
        rng: of the bootstrap.
        bootstrap: its resamples, and what an interval leaves on either side.
    """
    resamples, alpha = bootstrap
    weights = np.concatenate([rng.multinomial(k, np.full(k, 1.0 / k), resamples) for k in sizes], axis=1).astype(float)
    parts = [weights[begin : begin + _BATCH] for begin in range(0, resamples, _BATCH)]
    drawn = np.concatenate([_inner(products, sizes, part) for part in parts])
    ends = np.quantile(drawn, [alpha, 1.0 - alpha], axis=0)
    told = np.diagonal(ends[0]) > 0.0
    both = np.outer(told, told)
    value = np.where(both, _normalised(_inner(products, sizes, np.ones((1, len(products))))[0]), np.nan)
    between = both & ~np.eye(len(sizes), dtype=bool)
    low, high = (
        np.where(between, end, np.nan)
        for end in np.nanquantile(np.where(both, _normalised(drawn), 0.0), [alpha, 1.0 - alpha], axis=0)
    )
    return value, low, high, (ends[0] > 0.0).astype(np.intp) - (ends[1] < 0.0)


def _inner(products: Array, sizes: NDArray[np.intp], weights: Array) -> Array:
    """⟨∇J_a, ∇J_b⟩, shape (r, n, n), where episodes count several times; `weights` says how often, shape (r, k)."""
    first = _first(sizes)
    blocks = np.split(np.arange(len(products)), first[1:])
    rows = [np.add.reduceat((weights[:, own] @ products[own]) * weights, first, axis=1) for own in blocks]
    sums = np.stack(rows, axis=1)
    result, squares = sums / np.outer(sizes, sizes), np.einsum("raa->ra", sums)
    own = np.add.reduceat(weights**2 * np.diagonal(products), first, axis=1)
    pairs = sizes**2 - np.add.reduceat(weights**2, first, axis=1)
    every = np.arange(len(sizes))
    result[:, every, every] = np.divide(squares - own, pairs, where=pairs > 0.0, out=np.zeros_like(squares))
    return result


def _normalised(inner: Array) -> Array:
    """Divided by the roots of its diagonal, shape (…, n, n); NaN where one of these is not above 0."""
    squares = np.einsum("...aa->...a", inner)
    return _cosine(inner, squares[..., :, None], squares[..., None, :])


def _cosine(inner: Array, one: Array, other: Array) -> Array:
    """Inner products over the roots of squared lengths; NaN where one of these is not above 0."""
    known = (one > 0.0) & (other > 0.0)
    return np.where(known, inner, np.nan) / np.sqrt(np.where(known, one * other, 1.0))


def _first(sizes: NDArray[np.intp]) -> NDArray[np.intp]:
    """Place of the first episode of each context among all."""
    return np.concatenate([[0], np.cumsum(sizes)[:-1]])
