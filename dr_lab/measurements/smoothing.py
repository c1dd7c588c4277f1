"""Value and derivatives of a noisy signal by local polynomials, on samples at any times."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyvander
from numpy.typing import ArrayLike, NDArray

from dr_lab.errors import DataError
from dr_lab.trajectory import Array, Signal

Indices = NDArray[np.intp]

# Windows solved at once; bounds the memory of long signals and changes no result.
_BLOCK = 4096
_RIDGE = 1e-14  # of the scaled normal equations, which samples on one side of a long gap leave singular to rounding
_AMPLIFIED = 2.0  # noise of a sample; between samples four that a cubic goes through give 1.04, a gap soon hundreds


class LocalFit(NamedTuple):
    """Local polynomial at m times; the first axes of all fields are those of the times asked for.

    Attributes:
        value: smoothed signal, shape (m, …).
        slope: first derivative, shape (m, …).
        curvature: second derivative, shape (m, …); zero for degree 1.
        value_gain: standard deviation of `value` per unit of white noise in the samples, shape (m,).
        slope_gain: the same of `slope`, in 1/s, shape (m,).
    """

    value: Array
    slope: Array
    curvature: Array
    value_gain: Array
    slope_gain: Array


def local_polynomial(
    signal: Signal,
    at: ArrayLike,
    half_width: float,
    until: ArrayLike = np.inf,
    degree: int = 3,
    least: int | None = None,
) -> LocalFit:
    """Least-squares polynomial through the samples around each time, and its derivatives there.

    For each time s the coefficients c minimise Σ_i (y_i − Σ_k c_k (t_i − s)^k)² over the samples with
    |t_i − s| ≤ half_width and t_i ≤ until; the value is c_0, the slope c_1 and the curvature 2 c_2. Where that leaves
    fewer than `least` samples (gaps, ends, low rates) the nearest `least` are taken, or as many as there are: as many
    as coefficients would go through the noise. A polynomial signal up to the degree is reproduced exactly, at the ends
    as well. In a gap, where it makes more of the noise than `_AMPLIFIED`, a straight line between the gap's ends takes
    its place.

    Args:
        signal: samples, at least degree + 1 of them; a vector signal is fitted column by column.
        at: times in s, a number or shape (m,).
        half_width: of the window in s, > 0.
        until: no sample after this time in s is used, so that a start can be estimated from the past alone; a number
            or one for each time.
        degree: of the polynomial, ≥ 1.
        least: number of samples, more than the degree; None takes 2 · degree.

    Returns:
        The fit at each time, shapes as `at`.

    Raises:
        DataError: the signal has too few samples up to `until`.

    Source: Cleveland, W. S. 1979; on even samples the weights are those of Savitzky and Golay 1964.
    """
    times = np.asarray(at, dtype=np.float64)
    flat, last = (np.ravel(part) for part in np.broadcast_arrays(times, np.asarray(until, dtype=np.float64)))
    usable = np.searchsorted(signal.time, last, side="right")
    _require_samples(signal, usable, last, degree)
    fewest = 2 * degree if least is None else least
    blocks = [
        _solve(signal, flat[i : i + _BLOCK], usable[i : i + _BLOCK], half_width, degree, fewest)
        for i in range(0, max(len(flat), 1), _BLOCK)
    ]
    joined = LocalFit(*(np.concatenate(parts) for parts in zip(*blocks, strict=True)))
    found = _bridged(joined, signal, flat, usable)
    return LocalFit(*(part.reshape(times.shape + part.shape[1:]) for part in found))


def _require_samples(signal: Signal, usable: Indices, last: Array, degree: int) -> None:
    """Refuse times up to which a signal has fewer samples than a polynomial has coefficients."""
    if (usable <= degree).any():
        worst = int(np.argmin(usable))
        raise DataError(
            f"Signal {signal.name!r}: {usable[worst]} samples up to {last[worst]:.6g} s; a local polynomial of degree "
            f"{degree} needs {degree + 1}. Take a later time or a longer log."
        )


def _solve(signal: Signal, at: Array, usable: Indices, half_width: float, degree: int, least: int) -> LocalFit:
    time, value = signal.time, signal.value
    low, high = _windows(time, at, usable, half_width, least)
    index = low[:, None] + np.arange(int((high - low).max()))
    inside = index < high[:, None]
    index = np.minimum(index, len(time) - 1)
    offset = np.where(inside, time[index] - at[:, None], 0.0)
    # Scaled to [−1, 1], so that the normal equations stay well conditioned whatever the units.
    scale = np.abs(offset).max(axis=1)
    powers = np.arange(degree + 1)
    basis = polyvander(offset / scale[:, None], degree) * inside[..., None]  # its products take far less than powers
    inverse = np.linalg.inv(np.swapaxes(basis, 1, 2) @ basis + _RIDGE * np.eye(degree + 1))
    samples = value[index].reshape(*index.shape, -1)
    coefficients = inverse @ (np.swapaxes(basis, 1, 2) @ samples)
    gains = np.sqrt(np.diagonal(inverse, axis1=1, axis2=2)) / scale[:, None] ** powers
    shape = (len(at), *value.shape[1:])
    curvature = 2.0 * coefficients[:, 2] / scale[:, None] ** 2 if degree > 1 else np.zeros_like(coefficients[:, 0])
    return LocalFit(
        value=coefficients[:, 0].reshape(shape),
        slope=(coefficients[:, 1] / scale[:, None]).reshape(shape),
        curvature=curvature.reshape(shape),
        value_gain=gains[:, 0],
        slope_gain=gains[:, 1],
    )


def _bridged(fit: LocalFit, signal: Signal, at: Array, usable: Indices) -> LocalFit:
    """The fit, with straight lines between the samples on either side of those times at which it tells too little."""
    after = np.clip(np.searchsorted(signal.time, at), 1, len(signal) - 1)
    first, last = signal.time[after - 1], signal.time[after]
    gap = (fit.value_gain > _AMPLIFIED) & (first <= at) & (at <= last) & (after < usable)
    if not gap.any():
        return fit
    after, wait, share = after[gap], (last - first)[gap], ((at - first) / (last - first))[gap]
    rise, column = signal.value[after] - signal.value[after - 1], (-1,) + (1,) * (signal.value.ndim - 1)
    line = LocalFit(
        value=signal.value[after - 1] + share.reshape(column) * rise,
        slope=rise / wait.reshape(column),
        curvature=np.zeros_like(rise),
        value_gain=np.hypot(share, 1.0 - share),
        slope_gain=np.sqrt(2.0) / wait,
    )
    for part, straight in zip(fit, line, strict=True):
        part[gap] = straight
    return fit


def _windows(time: Array, at: Array, usable: Indices, half_width: float, least: int) -> tuple[Indices, Indices]:
    """First and one-past-last sample of each window, widened to the nearest `least` samples where it holds fewer."""
    low = np.minimum(np.searchsorted(time, at - half_width, side="left"), usable)
    high = np.minimum(np.searchsorted(time, at + half_width, side="right"), usable)
    few = np.flatnonzero(high - low < np.minimum(least, usable))
    if len(few):
        first = np.minimum(np.searchsorted(time, at[few]), usable[few])
        candidates = first[:, None] + np.arange(-least, least)
        exists = (candidates >= 0) & (candidates < usable[few, None])
        distance = np.abs(time[np.clip(candidates, 0, len(time) - 1)] - at[few, None])
        order = np.argsort(np.where(exists, distance, np.inf), axis=1, kind="stable")[:, :least]
        nearest, known = (np.take_along_axis(rows, order, axis=1) for rows in (candidates, exists))
        low[few] = np.where(known, nearest, len(time)).min(1)
        high[few] = np.where(known, nearest, -1).max(1) + 1
    return low, high
