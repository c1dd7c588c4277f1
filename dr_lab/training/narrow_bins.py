"""Bins of a picture that follow a distribution much narrower than the bounds of its parameter."""

from collections.abc import Sequence

import numpy as np

from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.trajectory import Array

UNSEEN = 1e-3  # share of draws beyond either end of a picture
_BINS = 60  # as many as lie within the bounds otherwise
_NARROW = 0.25  # of the whole range: a picture of it would show what is as narrow in few bins, and its shape badly
_LEAST = 1e-9  # of the bounds: what lies closer together is one value, which has no shape


def narrow_bins(randomizer: Randomizer, axis: int) -> tuple[Array, Array] | None:
    """Bins of a parameter's own around where p_φ(z) lies.

    Args:
        randomizer: p_φ(z).
        axis: which parameter.

    Returns:
        Edges (b + 1,) and the probability of each bin (b,); None where p_φ(z) is not much narrower than the bounds, or
        is one value.
    """
    span = float(randomizer.space.span[axis])
    edges = randomizer.edges(axis)
    share = randomizer.shares(axis, edges)
    wide = True
    while edges[-1] - edges[0] > _LEAST * span:
        first, last = seen(share[None])
        within = span if wide else edges[-1] - edges[0]
        if edges[last] - edges[first] >= _NARROW * within:
            return None if wide else (edges, share)
        edges = np.linspace(edges[max(first - 1, 0)], edges[min(last + 1, len(share))], _BINS + 1)
        share, wide = randomizer.shares(axis, edges), False
    return None


def seen(probability: Array) -> tuple[int, int]:
    """First bin that a picture shows and the first that it does not, of probabilities (k, b) at k times."""
    cumulated = probability.cumsum(1)
    first = int((cumulated < UNSEEN).sum(1).min())
    last = int((cumulated < cumulated[:, -1:] - UNSEEN).sum(1).max()) + 1
    return first, last


def shared_bins(own: Sequence[Array | None], wide: Array, span: float) -> tuple[Array, bool]:
    """Bins for a distribution at all its times: over where it ever lay, and finer where it began and where it ended.

    Args:
        own: the edges of each time, None where it was wide.
        wide: those over the bounds.
        span: width of the bounds.

    Returns:
        Edges, and whether they show only a narrow part of the bounds.
    """
    known = [edges for edges in own if edges is not None]
    low, high = min((e[0] for e in known), default=0.0), max((e[-1] for e in known), default=0.0)
    narrow = len(known) == len(own) and bool(high - low < _NARROW * span)
    edges = np.linspace(low, high, _BINS + 1) if narrow else wide
    for each in (own[0], own[-1]):
        if each is not None and each[-1] - each[0] < _NARROW * (edges[-1] - edges[0]):
            edges = _finer(edges, each)
    return edges, narrow


def rebinned(probability: Array, edges: Array, others: Array) -> Array:
    """Probabilities of other bins, of a density that is constant in each bin and 0 beyond them."""
    if np.array_equal(edges, others):
        return probability
    return np.diff(np.interp(others, edges, np.concatenate([[0.0], np.cumsum(probability)])))


def _finer(edges: Array, own: Array) -> Array:
    """Edges with finer ones in their place where these lie."""
    bin_width = own[1] - own[0]
    below, above = edges[edges < own[0] - bin_width], edges[edges > own[-1] + bin_width]
    return np.concatenate([below, own, above])
