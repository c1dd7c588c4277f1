"""Value and derivatives of a noisy signal by local polynomials, on samples at any times."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dr_lab.errors import DataError
from dr_lab.trajectory import Array, Signal

Indices = NDArray[np.intp]

# Windows solved at once; bounds the memory of long signals and changes no result.
_BLOCK = 4096


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
    signal: Signal, at: ArrayLike, half_width: float, until: float = np.inf, degree: int = 3
) -> LocalFit:
    """Least-squares polynomial through the samples around each time, and its derivatives there.

    For each time s the coefficients c minimise Σ_i (y_i − Σ_k c_k (t_i − s)^k)² over the samples with
    |t_i − s| ≤ half_width and t_i ≤ until; the value is c_0, the slope c_1 and the curvature 2 c_2. Where that leaves
    fewer than degree + 1 samples (gaps, ends, low rates) the nearest degree + 1 are taken. A polynomial signal up to
    the degree is reproduced exactly, at the ends as well.

    Args:
        signal: samples, at least degree + 1 of them; a vector signal is fitted column by column.
        at: times in s, a number or shape (m,).
        half_width: of the window in s, > 0.
        until: no sample after this time in s is used, so that a start can be estimated from the past alone.
        degree: of the polynomial, ≥ 1.

    Returns:
        The fit at each time, shapes as `at`.

    Raises:
        DataError: the signal has too few samples up to `until`.

    Source: Cleveland, W. S. 1979; on even samples the weights are those of Savitzky and Golay 1964.
    """
    times = np.asarray(at, dtype=np.float64)
    usable = int(np.searchsorted(signal.time, until, side="right"))
    if usable <= degree:
        raise DataError(
            f"Signal {signal.name!r}: {usable} samples up to {until:.6g} s; a local polynomial of degree {degree} "
            f"needs {degree + 1}. Take a later time or a longer log."
        )
    flat = np.atleast_1d(times)
    blocks = [
        _solve(signal.time[:usable], signal.value[:usable], flat[i : i + _BLOCK], half_width, degree)
        for i in range(0, len(flat), _BLOCK)
    ]
    joined = [np.concatenate(parts) for parts in zip(*blocks, strict=True)]
    return LocalFit(*(part.reshape(times.shape + part.shape[1:]) for part in joined))


def _solve(time: Array, value: Array, at: Array, half_width: float, degree: int) -> LocalFit:
    low, high = _windows(time, at, half_width, degree + 1)
    index = low[:, None] + np.arange(int((high - low).max()))
    inside = index < high[:, None]
    index = np.minimum(index, len(time) - 1)
    offset = np.where(inside, time[index] - at[:, None], 0.0)
    # Scaled to [−1, 1], so that the normal equations stay well conditioned whatever the units.
    scale = np.abs(offset).max(axis=1)
    powers = np.arange(degree + 1)
    basis = (offset / scale[:, None])[..., None] ** powers * inside[..., None]
    inverse = np.linalg.inv(np.swapaxes(basis, 1, 2) @ basis)
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


def _windows(time: Array, at: Array, half_width: float, least: int) -> tuple[Indices, Indices]:
    """First and one-past-last sample of each window, widened to the nearest `least` samples where it holds fewer."""
    low = np.searchsorted(time, at - half_width, side="left")
    high = np.searchsorted(time, at + half_width, side="right")
    few = np.flatnonzero(high - low < least)
    for i in few:
        first = int(np.searchsorted(time, at[i]))
        candidates = np.arange(max(first - least, 0), min(first + least, len(time)))
        nearest = np.sort(np.argsort(np.abs(time[candidates] - at[i]), kind="stable")[:least])
        low[i], high[i] = candidates[nearest[0]], candidates[nearest[-1]] + 1
    return low, high
