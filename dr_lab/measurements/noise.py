"""Standard deviation of a channel's measurement noise, from the data alone."""

from collections.abc import Sequence
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.lattice import lattice_step, on_lattice
from dr_lab.trajectory import Array, Noise, Signal

_ORDERS = range(2, 9)
# Most windows looked at per signal; windows per stretch; fewest windows that give an estimate.
_MOST = 20_000
_STRETCH = 100
_FEWEST = 10
# Residuals beyond this many standard deviations are not noise; the limit settles within a few rounds.
_FAR = 5.0
_TRIMS = 4
# Samples on each side over which a quantised signal's speed is judged.
_REACH = 8


class _Windows(NamedTuple):
    """Residuals of neighbouring samples, and which of them lie where a quantised signal moves fast."""

    residual: Array
    fast: NDArray[np.bool_]


def estimate_noise(signals: Sequence[Signal], longest_wait: float, contract: DataContract) -> Noise:
    """Estimate one channel's noise from all its logs.

    The larger of two figures: rounding to a step q has standard deviation q/√12 (the step is found from the values'
    lattice), and whatever a local polynomial cannot follow from sample to sample is noise. Rounding is as good as
    random only where a signal moves by `contract.fast` steps a sample: there a residual of up to `contract.quantised`
    times the rounding counts as rounding alone, in slower staircases one of up to `contract.staircase` times. Noise of
    more than a step (a residual of `contract.dithered` times the rounding) makes it random everywhere. Then slow parts
    count as well.

    Noise that changes slowly from sample to sample looks like motion here, and only its quick part is found. Whether
    what a model leaves beyond that is noise is judged by what forces can do (`dr_lab.diagnosis.evidence.colour`).

    Args:
        signals: the channel in each log, same unit; vector channels count all components.
        longest_wait: s, windows do not reach across longer times between samples.
        contract: thresholds.

    Returns:
        The noise, source ``"estimated"``.

    Raises:
        DataError: the channel never changes, so that nothing can be said.
    """
    columns = [(s.time, column) for s in signals for column in s.value.reshape(len(s), -1).T]
    span = max(float(np.ptp(column)) for _, column in columns)
    if span == 0.0:
        raise DataError(
            f"Channel {signals[0].name!r} never changes, so its noise cannot be estimated; give noise_std, or check "
            "that the right topic or column is read."
        )
    return Noise(max(_std(columns, longest_wait, contract), contract.noise_floor * span), signals[0].unit, "estimated")


def _std(columns: Sequence[tuple[Array, Array]], longest_wait: float, contract: DataContract) -> float:
    step = _common_step([column for _, column in columns])
    if step is None:
        moving = [_drop_repeats(time, value) for time, value in columns]
        return max(_settled(moving, longest_wait, 0.0, contract, fast=False), _apart_at_rest(columns) / np.sqrt(12.0))
    rounding = step / np.sqrt(12.0)
    every = _settled(columns, longest_wait, 0.0, contract, fast=False)
    fast = _settled(columns, longest_wait, contract.fast * step, contract, fast=True)
    if fast == 0.0:
        return every if every > contract.staircase * rounding else rounding
    if every > contract.dithered * rounding:
        return max(min(fast, every), rounding)  # a servo that jumps and rests leaves less than that at rest
    # A uniform motion by half a step more than whole ones rounds up and down by turns, but every other sample alike.
    others = _settled(columns, longest_wait, contract.fast * step, contract, fast=True, apart=2) or fast
    return fast if min(fast, others) > contract.quantised * rounding else rounding


def _common_step(columns: Sequence[Array]) -> float | None:
    """The step of half of the columns that change; those that hold few values are of a step that others tell."""
    moving = [column for column in columns if np.ptp(column) > 0]
    found = [lattice_step(column) for column in moving]
    steps = sorted(step for step in found if step is not None)
    if not steps:
        return None
    common = steps[(len(steps) - 1) // 2]
    agree = sum(step is not None or on_lattice(column, common) for column, step in zip(moving, found, strict=True))
    return common if 2 * agree >= len(moving) else None


def _apart_at_rest(columns: Sequence[tuple[Array, Array]]) -> float:
    """The smallest distance of two values where most samples repeat the one before, as at rest; else 0.

    The few values that such a channel takes may not tell its step, but it is no more than that.
    """
    repeats = np.concatenate([np.diff(value) == 0.0 for _, value in columns])
    values = np.unique(np.concatenate([value for _, value in columns]))
    return float(np.diff(values).min()) if 2 * repeats.sum() > len(repeats) else 0.0


def _settled(
    columns: Sequence[tuple[Array, Array]],
    longest_wait: float,
    speed: float,
    contract: DataContract,
    *,
    fast: bool,
    apart: int = 1,
) -> float:
    """Standard deviation of what polynomials through every sample, or samples `apart` from each other, cannot follow.

    A polynomial of degree m − 1 through m + 1 samples at any times leaves one residual e = Σ_j w_j y_j with
    w_j ∝ Π_{k≠j} 1/(t_j − t_k), Σ w_j² = 1: the divided difference of order m. White noise of standard deviation σ
    gives e the same σ for every m, while a smooth signal's share falls with m; the order is raised until the estimate
    settles. Returns 0 if there are too few windows.
    """
    previous = 0.0
    for order in _ORDERS:
        parts = [_windows(time, value, order, longest_wait, speed, apart) for time, value in columns]
        chosen = [part.residual[part.fast] if fast else part.residual for part in parts]
        std = _typical_std(np.concatenate(chosen), order)
        if std == 0.0:
            return 0.0
        if std > (1.0 - contract.noise_settled) * previous > 0.0:
            return 0.5 * (std + previous)
        previous = std
    return previous


def _typical_std(residual: Array, order: int) -> float:
    """Root of the median variance of stretches, which impacts and reversals in some of them do not move.

    Residuals beyond five standard deviations (glitches) are left out, and the standard deviation taken anew.

    The median of a variance with ν degrees of freedom is (1 − 2/(9ν))³ of its mean (Wilson and Hilferty 1931);
    residuals that share samples have ν = n C(2m, m)² / C(4m, 2m) degrees of freedom for n windows of order m.
    """
    freedom = _STRETCH * comb(2 * order, order) ** 2 / comb(4 * order, 2 * order)
    std = np.inf
    for _ in range(_TRIMS):
        residual = residual[np.abs(residual) <= _FAR * std]
        if len(residual) < _FEWEST:
            return 0.0
        count = max(len(residual) // _STRETCH, 1)
        length = min(len(residual), _STRETCH)
        variances = (residual[: count * length].reshape(count, length) ** 2).mean(axis=1)
        share = 1.0 if count == 1 else (1.0 - 2.0 / (9.0 * freedom)) ** 3
        std = float(np.sqrt(np.median(variances) / share))
    return std


def _windows(time: Array, value: Array, order: int, longest_wait: float, speed: float, apart: int) -> _Windows:
    length = apart * order
    count = len(time) - length
    if count < 1:
        return _Windows(np.empty(0), np.empty(0, dtype=np.bool_))
    starts = np.unique(np.linspace(0, count - 1, min(count, _MOST)).astype(np.intp))
    members = starts + apart * np.arange(order + 1)[:, None]
    times, values = time[members], value[members]
    before, after = np.maximum(starts - _REACH, 0), np.minimum(starts + length + _REACH, len(value) - 1)
    fast = np.abs(value[after] - value[before]) >= speed * (after - before)
    usable = np.diff(times, axis=0).max(axis=0) <= apart * longest_wait
    return _Windows(_weighted(times[:, usable], values[:, usable]), fast[usable])


def _weighted(times: Array, values: Array) -> Array:
    """Residuals of windows given as columns."""
    if times.shape[1] == 0:
        return np.empty(0)
    # In units of the window's mean period, so that products of many differences neither vanish nor overflow.
    apart = (times[:, None] - times[None]) / ((times[-1] - times[0]) / (len(times) - 1))
    apart[np.arange(len(times)), np.arange(len(times))] = 1.0
    weights = 1.0 / apart.prod(axis=1)
    return (weights * values).sum(axis=0) / np.sqrt((weights**2).sum(axis=0))


def _drop_repeats(time: Array, value: Array) -> tuple[Array, Array]:
    """Drop exact repeats of a continuous signal: a sensor slower than its topic holds its value."""
    new = np.concatenate([[True], np.diff(value) != 0.0])
    return time[new], value[new]
