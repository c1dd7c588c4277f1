"""How many residuals are independent: their correlation within windows."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]


def autocorrelation(residual: Array, used: Mask) -> Array:
    """Autocorrelation within windows at lags of 0, 1, … samples, ρ_k = Σ r_t r_{t+k} / Σ r_t², per pair; shape (m,).

    Args:
        residual: residuals of w windows, shape (w, m).
        used: which of them exist, shape (w, m).
    """
    if not residual.size:
        return np.eye(1, residual.shape[1])[0]
    values, count = np.where(used, residual, 0.0), used.astype(np.float64)
    products, pairs = (_lagged(rows) for rows in (values, count))
    mean = np.divide(products, pairs, out=np.zeros_like(products), where=pairs > 0.5)
    return mean / mean[0] if mean[0] > 0 else np.eye(1, len(mean))[0]


def correlation_time(rho: Array) -> float:
    """1 + 2 Σ ρ_k in samples, up to the first ρ_k that is not positive: so many residuals tell as much as one does.

    Source: Geyer, Statistical Science 7 (1992) 473, section 3.3 (initial positive sequence).
    """
    return 1.0 + 2.0 * float(_positive(rho).sum())


def variance_time(rho: Array) -> float:
    """1 + 2 Σ ρ_k² in samples: so many squares tell as much of the variance as one does (Bartlett 1946)."""
    return 1.0 + 2.0 * float((_positive(rho) ** 2).sum())


def colour(parts: Iterable[tuple[Array, Mask]]) -> float:
    """Residuals that tell as much as one independent one does, over all channels, at least 1.

    Args:
        parts: residuals of each channel and which of them exist, shapes (w, m, size).
    """
    total, independent = 0.0, 0.0
    for residual, used in parts:
        count = float(used.sum())
        total += count
        independent += count / correlation_time(autocorrelation(by_component(residual), by_component(used)))
    return total / independent if independent else 1.0


def by_component(part: NDArray[Any]) -> NDArray[Any]:
    """Components of a vector as windows of their own, (w, m, size) → (w · size, m)."""
    return part.transpose(0, 2, 1).reshape(part.shape[0] * part.shape[2], part.shape[1])


def _lagged(rows: Array) -> Array:
    """Σ over rows and t of x(t) x(t + k), shape (m,)."""
    m = rows.shape[1]
    return np.fft.irfft((np.abs(np.fft.rfft(rows, 2 * m)) ** 2).sum(0), 2 * m)[:m]


def _positive(rho: Array) -> Array:
    """The correlations at lags from 1 up to the first that is not positive; of the last half lags too few pairs are."""
    tail = rho[1 : max(len(rho) // 2, 1)]
    ends = np.flatnonzero(tail <= 0)
    return tail[: ends[0]] if len(ends) else tail
