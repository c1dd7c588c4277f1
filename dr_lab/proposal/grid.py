"""The series of some logs, smoothed, at the times of a few test functions."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.faults.equation_error import Weak
from dr_lab.diagnosis.faults.smoothed_motion import smooth
from dr_lab.diagnosis.windows.commands import averages
from dr_lab.errors import DataError
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.survey import Series
from dr_lab.trajectory import Array, Signal

_TURNS = (2 * np.pi, 360.0)  # of angles that wrap
_WRAPS = 0.1  # share of a turn within which a jump is one
_MARGIN = 1.0  # s
_GAP = 5.0  # periods without a sample


@dataclass(frozen=True)
class Grid:
    """w test functions φ ∝ (1 − x²)³ over the logs, m times each, n = w·m.

    Attributes:
        log: of each test function, shape (w,).
        time: shape (w, m), s.
        weight: φ times the step, shape (m,).
        step: s.
    """

    log: NDArray[np.intp]
    time: Array
    weight: Array
    step: float

    @property
    def weak(self) -> Weak:
        """As the diagnosis projects by them."""
        index = np.arange(self.time.size).reshape(self.time.shape)
        return Weak(self.log, self.time.mean(1), index, self.weight)


@dataclass(frozen=True)
class Path:
    """A smoothed series at all n times of a grid.

    Attributes:
        value: raw numbers, shape (n,); wraps are undone.
        slope: per s.
        curvature: per s².
        turn: full turn by which it wraps, in its unit; 0 where it does not.
    """

    value: Array
    slope: Array
    curvature: Array
    turn: float


def grid_of(series: Sequence[Series], settings: ProposalSettings) -> Grid:
    """Even test functions over the time that all series of a log share.

    Raises:
        DataError: no log is long enough.
    """
    count = len(series[0].signals)
    half = max(round(settings.half_width / settings.grid), 2)
    shape = (1 - (np.arange(-half, half + 1) / (half + 1)) ** 2) ** 3
    reach, each = (half + 1) * settings.grid, max(settings.tests // count, 4)
    logs, times = [], []
    for k in range(count):
        first = max(s.signals[k].time[0] for s in series) + reach
        last = min(min(s.signals[k].time[-1] for s in series) - reach, first + settings.seconds)
        if last > first:
            middles = np.linspace(first, last, each)
            middles = middles[_held(middles, [s.signals[k] for s in series], reach)]
            times.append(middles[:, None] + settings.grid * np.arange(-half, half + 1))
            logs += [k] * len(middles)
    if not logs:
        raise DataError(
            f"No log lasts {2 * reach:.2g} s without a pause in which all its series are known. Record a longer one."
        )
    return Grid(np.array(logs), np.concatenate(times), shape / shape.sum(), settings.grid)


def known_in(series: Sequence[Series], grid: Grid) -> NDArray[np.bool_]:
    """Which test functions lie in time that some series share and in which none of them pauses, shape (w,)."""
    known = np.zeros(len(grid.log), bool)
    for k in np.unique(grid.log):
        signals, rows = [each.signals[k] for each in series], grid.log == k
        begin, end = max(s.time[0] for s in signals), min(s.time[-1] for s in signals)
        reach = 0.5 * float(np.ptp(grid.time[0]))
        within = (grid.time[rows, 0] >= begin) & (grid.time[rows, -1] <= end)
        known[rows] = within & _held(grid.time[rows].mean(1), signals, reach)
    return known


def path_of(series: Series, grid: Grid, cutoff: float, *, rate: bool = False) -> Path:
    """Smooth a series and evaluate it on a grid; a rate is integrated from the beginning of every log on."""
    parts = np.zeros((3, *grid.time.shape))
    turn = 0.0 if rate else max(wrapped(signal.value) for signal in series.signals)
    for k, signal in enumerate(series.signals):
        rows = grid.log == k
        if rows.any():
            spline = smooth(_around(_unwrapped(signal, turn), grid.time[rows]), cutoff)
            if rate:
                spline = spline.antiderivative()
            for order in range(3):
                parts[order, rows] = spline(grid.time[rows], order)
    value, slope, curvature = parts.reshape(3, -1)
    return Path(value, slope, curvature, turn)


def held_of(series: Series, grid: Grid, lag: float) -> Array:
    """A series whose samples hold until the next, as time averages over the grid's steps, `lag` s late, shape (n,)."""
    found = np.zeros(grid.time.shape)
    edges = np.append(grid.time, grid.time[:, -1:] + grid.step, axis=1) - 0.5 * grid.step - lag
    for k, signal in enumerate(series.signals):
        rows = grid.log == k
        if rows.any():
            found[rows] = averages({"": signal}, {"": 0}, 1, edges[rows])[:, :, 0]
    return found.ravel()


def integral_of(series: Series, grid: Grid, lag: float) -> Array:
    """What `held_of` holds, integrated from the beginning of every log on, shape (n,)."""
    found = np.zeros(grid.time.shape)
    for k, signal in enumerate(series.signals):
        rows = grid.log == k
        if rows.any():
            last = max(float(signal.time[-1]), float(grid.time[rows].max())) + _MARGIN
            ends = np.append(signal.time, last)
            total = np.concatenate([[0.0], np.cumsum(signal.value * np.diff(ends))])
            found[rows] = np.interp(grid.time[rows] - lag, ends, total)
    return found.ravel()


def wrapped(values: Array) -> float:
    """The full turn, 2π or 360, by which most large jumps of a series go; 0 where there are none."""
    jumps = np.abs(np.diff(values))
    large = jumps[jumps > 0.5 * max(float(jumps.max(initial=0.0)), _TURNS[0])]
    for turn in _TURNS:
        if len(large) and (np.abs(large - turn) < _WRAPS * turn).all() and np.ptp(values) < (1 + _WRAPS) * turn:
            return turn
    return 0.0


def _around(signal: Signal, time: Array) -> Signal:
    """The part of a signal about some times: the rest of a long log costs and tells nothing."""
    near = (signal.time >= time.min() - _MARGIN) & (signal.time <= time.max() + _MARGIN)
    return Signal(signal.name, signal.unit, signal.time[near], signal.value[near])


def _unwrapped(signal: Signal, turn: float) -> Signal:
    if turn == 0.0:
        return signal
    return Signal(signal.name, signal.unit, signal.time, np.unwrap(signal.value, period=turn))


def _held(middles: Array, signals: Sequence[Signal], reach: float) -> NDArray[np.bool_]:
    """Which test functions reach into no pause of any signal."""
    free = np.ones(len(middles), bool)
    for signal in signals:
        waits = np.diff(signal.time)
        pauses = np.flatnonzero(waits > max(_GAP * np.median(waits), reach))
        for k in pauses:
            free &= (middles + reach < signal.time[k]) | (middles - reach > signal.time[k + 1])
    return free
