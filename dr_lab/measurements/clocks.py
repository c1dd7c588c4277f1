"""Offset and drift of one clock against another, from messages that carry both."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Array, ClockFit, Note

# Stamps are grouped before the hull is built; enough groups that one holds a few messages at most rates.
_GROUPS = 1000
_MAD_TO_STD = 1.4826


class ClockLine(NamedTuple):
    """A straight line through the log clock: t_log = t + offset + drift · t, all in s since the clocks' zeros."""

    offset: float
    drift: float

    def to_log(self, elapsed: Array) -> Array:
        """Map times of the channel's clock to the log's."""
        return elapsed + self.offset + self.drift * elapsed


def fit_line(elapsed: Array, log: Array, contract: DataContract) -> ClockLine:
    """Estimate offset and drift of the log clock against a sender's clock.

    A message is logged after it was stamped, by a delay that is never negative and often late, so the clocks' line is
    the lower envelope of d_i = log_i − elapsed_i rather than their mean: of all lines below every point, the one with
    the least total distance to them, min Σ (d_i − a − b t_i) subject to a + b t_i ≤ d_i. That line carries the edge of
    the lower convex hull above the mean of t. The shortest delay itself cannot be told from the clocks' offset.

    Args:
        elapsed: stamps of the sender, shape (n,), n ≥ 1.
        log: log times of the same messages, shape (n,).
        contract: which few stamps are left out because they lie far below the others.

    Source: Moon, Skelly and Towsley 1999, "Estimation and removal of clock skew from network delay measurements".
    """
    delay = log - elapsed
    rough = _rough_line(elapsed, delay)
    rest = delay - np.polyval(rough, elapsed)
    spread = _MAD_TO_STD * float(np.median(np.abs(rest - np.median(rest))))
    suspect = rest < np.median(rest) - contract.clock_outlier * spread
    if suspect.mean() <= contract.clock_outlier_share:
        elapsed, rest = elapsed[~suspect], rest[~suspect]
    offset, drift = _envelope(elapsed, rest)
    return ClockLine(float(rough[1] + offset), float(rough[0] + drift))


def pool(
    lines: Mapping[str, ClockLine], stamps: Mapping[str, tuple[Array, Array]], contract: DataContract
) -> dict[str, ClockLine]:
    """Give topics whose headers carry the same clock one common line.

    Their own lines differ by the topics' shortest delays, which would appear as a shift in time between signals that
    one computer stamped together.

    Args:
        lines: fitted lines by topic.
        stamps: (elapsed, log) by topic.
        contract: how close two lines must be to be one clock.

    Returns:
        The line of each topic.
    """
    groups: list[list[str]] = []
    for topic in lines:
        group = next((g for g in groups if _agree(lines[g[0]], lines[topic], stamps[topic][0], contract)), None)
        if group is None:
            groups.append([topic])
        else:
            group.append(topic)
    pooled: dict[str, ClockLine] = {}
    for group in groups:
        elapsed, log = (np.concatenate([stamps[topic][i] for topic in group]) for i in (0, 1))
        line = fit_line(elapsed, log, contract) if len(group) > 1 else lines[group[0]]
        pooled |= dict.fromkeys(group, line)
    return pooled


def describe(clock: str, elapsed: Array, log: Array, line: ClockLine, zero: float) -> ClockFit:
    """Write a line down with its offset at the channel's first sample.

    Args:
        clock: name of the channel's clock.
        elapsed: its stamps.
        log: log times of the same messages.
        line: the clocks' line.
        zero: the channel clock's zero in s after the log's.
    """
    late = log - line.to_log(elapsed)
    jitter = float(np.median(np.abs(late - np.median(late))))
    return ClockFit(clock, line.offset - zero + line.drift * float(elapsed[0]), line.drift, jitter)


def steps(topic: str, elapsed: Array, log: Array, line: ClockLine, contract: DataContract) -> list[Note]:
    """Report a clock that does not run straight, e.g. one that was set while the log was recorded."""
    late = log - line.to_log(elapsed)
    lowest = [float(part.min()) for part in np.array_split(late, 20) if len(part)]
    worst = max(lowest, default=0.0)
    if worst <= contract.clock_step:
        return []
    message = (
        f"The header clock of {topic} leaves a straight line by {worst * 1e3:.3g} ms against the log time; "
        "it was set or stalled during the recording. Cut the log there, or use clock: log."
    )
    return [Note("clock", "", message, int((late > worst).sum()))]


def require_rate(topic: str, elapsed: Array, log: Array, contract: DataContract) -> None:
    """Refuse stamps that run at another rate than the log, or backwards.

    Both the median rate of stretches and the rate from the first to the last must be off: a clock that was set on the
    way changes only the latter, late and bunched messages of a short log only the former.

    Raises:
        DataError: a second of the sender's clock is not a second of the log's.
    """
    moves = np.diff(np.array([[np.median(t[part]) for part in _stretches(len(t))] for t in (elapsed, log)]))
    lasted, moving = moves[1].sum(), moves[1] > 0
    if lasted <= 0:
        return
    rate, usual = moves[0].sum() / lasted, np.median(moves[0, moving] / moves[1, moving])
    if min(abs(rate - 1.0), abs(usual - 1.0)) <= contract.clock_drift:
        return
    told = f"{rate:.3g} times as fast as the log time" if rate > 0 else "backwards"
    raise DataError(
        f"The header stamps of {topic} run {told}; a computer's clock keeps to it within {contract.clock_drift:.0%}. "
        "If they count simulated time, record the log by it, too (ros2 bag record --use-sim-time); if they are wrong, "
        "use clock: log."
    )


def _stretches(count: int) -> list[NDArray[np.intp]]:
    """Indices of up to 20 stretches of a log."""
    return [part for part in np.array_split(np.arange(count), 20) if len(part)]


def _rough_line(elapsed: Array, delay: Array) -> Array:
    """Line (slope, intercept) through the medians of up to 20 stretches: deaf to single late messages."""
    parts = _stretches(len(elapsed))
    centres = np.array([np.median(elapsed[p]) for p in parts])
    medians = np.array([np.median(delay[p]) for p in parts])
    if np.ptp(centres) == 0.0:
        return np.array([0.0, medians[0]])
    return np.polyfit(centres, medians, 1)


def _envelope(x: Array, y: Array) -> tuple[float, float]:
    """Intercept and slope of the lower hull's edge above the mean of x."""
    if np.ptp(x) == 0.0:
        return float(y.min()), 0.0
    hull = _lower_hull(*_lowest_of_groups(x, y))
    if len(hull) == 1:
        return hull[0][1], 0.0
    knots = [point[0] for point in hull]
    i = int(np.clip(np.searchsorted(knots, x.mean()), 1, len(hull) - 1))
    (x0, y0), (x1, y1) = hull[i - 1], hull[i]
    slope = (y1 - y0) / (x1 - x0)
    return y0 - slope * x0, slope


def _lowest_of_groups(x: Array, y: Array) -> tuple[Array, Array]:
    group = np.minimum(((x - x.min()) / np.ptp(x) * _GROUPS).astype(np.intp), _GROUPS - 1)
    order = np.lexsort((y, group))
    _, first = np.unique(group[order], return_index=True)
    chosen = order[first]
    return x[chosen], y[chosen]


def _lower_hull(x: Array, y: Array) -> Sequence[tuple[float, float]]:
    """Andrew's monotone chain; x increases."""
    hull: list[tuple[float, float]] = []
    for point in zip(x.tolist(), y.tolist(), strict=True):
        while len(hull) > 1 and _turn(hull[-2], hull[-1], point) <= 0:
            hull.pop()
        hull.append(point)
    return hull


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _agree(a: ClockLine, b: ClockLine, elapsed: Array, contract: DataContract) -> bool:
    ends = np.array([elapsed[0], elapsed[-1]])
    return bool((np.abs(a.to_log(ends) - b.to_log(ends)) <= contract.same_clock).all())
