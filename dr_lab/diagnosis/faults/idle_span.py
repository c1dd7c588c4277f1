"""The span of a log in which commands do nothing, though they act elsewhere: the machine is off."""

import numpy as np

from dr_lab.diagnosis.faults.drive_fit import DriveFit, Gain
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.smoothed_motion import Mask
from dr_lab.trajectory import Array

_REFINEMENTS = 3  # of the span
_REACH = 2  # test functions that overlap by half or more


def idle_span(fit: DriveFit, settings: FaultSettings) -> slice | None:
    """The span in which the motion needs no drive, whatever the commands say.

    A first gain comes from the whole log, or, where most of it may be idle, from its beginning or its end.
    """
    every = np.arange(len(fit.time)) / len(fit.time)
    for first in (every >= 0.0, every < settings.active, every >= 1 - settings.active):
        span = _refined(fit, first, settings)
        if span is not None and _surely_idle(fit, span, settings):
            _, driven, without = _readings(fit, settings.gain**0.5, outside(fit, span))
            return _widened(span, driven - without)
    return None


def _widened(span: slice, score: Array) -> slice:
    """A span with what lies beside it, as far as that speaks for idle commands as well."""
    before, after = score[: span.start][::-1].cumsum(), score[span.stop :].cumsum()
    back, on = (int(part.argmax()) + 1 if len(part) and part.max() > 0 else 0 for part in (before, after))
    return slice(span.start - back, span.stop + on)


def _refined(fit: DriveFit, rows: Mask, settings: FaultSettings) -> slice | None:
    """The span that speaks most for idle commands, by gains of what lies outside of it."""
    least, span = settings.gain**0.5, None  # the span itself lowers the first gain
    for _ in range(_REFINEMENTS):
        _, driven, without = _readings(fit, least, rows)
        span = _largest(driven - without - 2 * driven[rows].mean())
        if span is None:
            return None
        rows = outside(fit, span)
        if rows.mean() < 1 - settings.active:
            return None
    return span


def _surely_idle(fit: DriveFit, span: slice, settings: FaultSettings) -> bool:
    rows = outside(fit, span)
    best, driven, without = _readings(fit, settings.gain**0.5, rows)
    return bool(
        fit.time[span][-1] - fit.time[span][0] >= settings.shortest_off
        and without[span].sum() <= settings.idle * driven[span].sum()
        and driven[span].mean() >= settings.idle_contrast * driven[rows].mean()
        and best.left <= settings.contrast * fit.gain(0.0, 0.0, rows).left
        and not _held(fit, best, span, rows, settings)
    )


def _readings(fit: DriveFit, least: float, rows: Mask) -> tuple[Gain, Array, Array]:
    """The gain on some test functions, and the squares left of all with the drive and without it."""
    best = fit.gain(least, 1 / least, rows)
    return best, (best.rest - best.gain * fit.drive) ** 2, best.rest**2


def outside(fit: DriveFit, span: slice) -> Mask:
    """Test functions that do not reach into a span."""
    rows = np.ones(len(fit.time), bool)
    rows[max(span.start - _REACH, 0) : span.stop + _REACH] = False
    return rows


def _held(fit: DriveFit, best: Gain, span: slice, rows: Mask, settings: FaultSettings) -> bool:
    """Whether the joint rests in a span where friction, or a stop on one side, may hold it against the drive."""
    speed = np.sqrt((fit.speed**2)[rows].mean())
    if np.sqrt((fit.speed**2)[span].mean()) > settings.resting * speed:
        return False
    drive, friction = best.gain * fit.drive[span], settings.breakaway * best.friction
    return not (drive.max() > friction and drive.min() < -friction)


def _largest(score: Array) -> slice | None:
    """The run with the largest sum, None where no score is positive (Kadane)."""
    total = np.concatenate([[0.0], np.cumsum(score)])
    lowest = np.minimum.accumulate(total[:-1])
    end = int((total[1:] - lowest).argmax())
    if total[end + 1] - lowest[end] <= 0:
        return None
    start = int(total[: end + 1].argmin())
    return slice(start, end + 1)
