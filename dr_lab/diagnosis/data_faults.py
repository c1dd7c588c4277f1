"""Faults of logs that a model shows: commands of the wrong sign or unit, out of step, or without effect."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dr_lab.diagnosis.drive_fit import DriveFit, Gain, Mask, drive_fits
from dr_lab.diagnosis.fault_words import factor_words, remedy_of_factor
from dr_lab.diagnosis.smoothed_motion import EquationErrorSettings, smoothed_motion, untestable
from dr_lab.errors import require_numbers
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, MeasurementSet

_REFINEMENTS = 3  # of the span in which a machine seems off
_REACH = 2  # test functions that overlap by half or more
_MOST_OF = 0.6  # of a log's test functions must know the commands of another time


@dataclass(frozen=True)
class FaultSettings:
    """When a fault of a log is told.

    Attributes:
        equation: how the equation of motion is tested.
        gain: commands that act with less than this, or more than its inverse, have another unit or do nothing.
        contrast: another reading of the commands must leave at most this share of the squares that the given one does.
        share: the given reading must leave at least this share of the squares of what the motion needs.
        longest_delay: s, no machine reacts later; what is later is a shift of the log.
        longest_shift: s, longest shift looked for.
        shift_step: s, between the shifts tried.
        shortest_off: s, shortest span in which a machine can be seen to be off.
        idle: share of the drive's squares that the motion's need leaves in such a span, at most.
        idle_contrast: what the drive leaves there exceeds what it leaves elsewhere by this factor.
        resting: speed as a share of the log's below which a joint counts as at rest in a span.
        breakaway: friction holds a joint at rest against this many times the friction of its motion.

    Raises:
        ConfigError: a number is out of its range.
    """

    equation: EquationErrorSettings
    gain: float
    contrast: float
    share: float
    longest_delay: float
    longest_shift: float
    shift_step: float
    shortest_off: float
    idle: float
    idle_contrast: float
    resting: float
    breakaway: float

    def __post_init__(self) -> None:
        positive = ("gain", "contrast", "share", "longest_delay", "longest_shift", "shift_step", "shortest_off", "idle")
        least = {"idle_contrast": 1.0, "resting": 0.0, "breakaway": 1.0}
        require_numbers(self, "faults", positive=positive, least=least, below=dict.fromkeys(("gain", "contrast"), 1.0))


@dataclass(frozen=True)
class Fault:
    """What seems wrong with a log.

    Attributes:
        kind: ``"sign"``, ``"unit"``, ``"shift"``, ``"off"`` or ``"decimated"``.
        log: the log's name.
        signal: the command's.
        begin: s on the log's clock.
        end: s.
        message: what was seen, with figures.
        remedy: what to write or to do.
    """

    kind: str
    log: str
    signal: str
    begin: float
    end: float
    message: str
    remedy: str


def suspect_faults(model: Model, measured: MeasurementSet, settings: FaultSettings) -> tuple[Fault, ...]:
    """Test the commands of all logs against the motion that they made, by inverse dynamics of the nominal model.

    Of each actuator and log the drive is regressed on what the joint's motion needs, beside friction, a spring, an
    offset and the errors that a nominal model may have. A fault is told where another reading of the commands (another
    sign, a factor, a shift in time, none at all) leaves far fewer squares than the given one with any plausible gain.
    Machines in contact throughout, with joints that are not measured or without commands are not tested.

    Args:
        model: the model as given.
        measured: all logs.
        settings: thresholds.

    Returns:
        The faults, log by log; none where nothing can be tested.
    """
    compiled, logs = model.nominal(), (*measured.fit, *measured.held_out)
    if untestable(compiled, measured) or not any(log.commands for log in logs):
        return ()
    motion = smoothed_motion(compiled, measured, logs, settings.equation)
    fits = drive_fits(compiled, logs, motion, settings.equation)
    return tuple(fault for fit in fits for fault in _faults(fit, settings))


def _faults(fit: DriveFit, settings: FaultSettings) -> list[Fault]:
    """At most one fault of a command in a log."""
    given = fit.gain(settings.gain, 1 / settings.gain)
    idle = fit.gain(0.0, 0.0)
    for test in (_sign, _unit, _off, _shift):
        found = test(fit, given, idle, settings)
        if found is not None:
            return [found]
    return []


def _sign(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    other = fit.gain(-1 / settings.gain, -settings.gain)
    if not _better(fit, other, given, settings) or other.left > settings.contrast * idle.left:
        return None
    message = (
        f"{fit.actuator}: the motion of {fit.joint} follows the commands with the opposite sign (gain "
        f"{other.gain:.2g}); with the given sign {_ratio(given, other)} times the squares are left."
    )
    sign = f"Write sign: -1 in measurements.commands.{fit.actuator}, or turn the sign of {fit.joint}'s channels."
    return _whole("sign", fit, message, sign)


def _unit(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    bounds = ((1 / settings.gain, np.inf), (0.0, settings.gain), (-np.inf, -1 / settings.gain), (-settings.gain, 0.0))
    other = min((fit.gain(low, high) for low, high in bounds), key=lambda gain: gain.left)
    if not _better(fit, other, given, settings) or other.left > settings.contrast * idle.left:
        return None
    message = (
        f"{fit.actuator}: the motion of {fit.joint} asks for {other.gain:.3g} times the commands' force"
        f"{factor_words(other.gain)}."
    )
    return _whole("unit", fit, message, remedy_of_factor(fit.actuator, other.gain))


def _shift(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    del idle
    if given.left < settings.share * float(fit.need @ fit.need):
        return None
    count = round(settings.longest_shift / settings.shift_step)
    lags = settings.shift_step * np.arange(-count, count + 1)
    tried = [found for lag in lags if (found := _shifted(fit, float(lag), settings)) is not None]
    best = min(tried, key=lambda found: found.share)
    near = min(found.share for found in tried if abs(found.lag) <= settings.longest_delay)
    if abs(best.lag) <= settings.longest_delay or best.share > settings.contrast * min(near, 1.0):
        return None
    if best.late.left > settings.contrast * fit.gain(0.0, 0.0, best.rows).left:
        return None
    message = (
        f"{fit.actuator}: the motion of {fit.joint} follows the commands {abs(best.lag):.2f} s "
        f"{'later' if best.lag > 0 else 'earlier'} than they are stamped (gain {best.late.gain:.2g}); as stamped "
        f"{_ratio(best.given, best.late)} times the squares are left."
    )
    remedy = (
        f"Check the clock of {fit.actuator}; where its stamps are off by a constant, write latency: {-best.lag:.2f} in "
        f"measurements.commands.{fit.actuator}, or leave the log out."
    )
    return _whole("shift", fit, message, remedy)


class _Shifted(NamedTuple):
    """Commands read as if they came later by a lag, beside the given ones on the same test functions."""

    lag: float
    late: Gain
    given: Gain
    rows: Mask

    @property
    def share(self) -> float:
        """What the later commands leave of the squares that the given ones do."""
        return self.late.left / max(self.given.left, np.finfo(float).tiny)


def _shifted(fit: DriveFit, lag: float, settings: FaultSettings) -> _Shifted | None:
    """Both readings; None where a log has too few test functions that know the later commands."""
    drive, rows = fit.late(lag)
    if rows.sum() < _MOST_OF * len(rows):
        return None
    bounds = (settings.gain, 1 / settings.gain)
    return _Shifted(lag, fit.gain(*bounds, rows, drive), fit.gain(*bounds, rows), rows)


def _off(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    """A span in which commands do nothing, though they act outside of it; or the whole log."""
    if _better(fit, idle, given, settings):
        message = f"{fit.actuator}: its commands do nothing to {fit.joint} in the whole log."
        return _whole("off", fit, message, f"Was the machine on? Leave the log out, or name {fit.actuator}'s channel.")
    span = _idle_span(fit, settings)
    if span is None:
        return None
    begin, end = float(fit.time[span][0]), float(fit.time[span][-1])
    best = fit.gain(settings.gain, 1 / settings.gain, _outside(fit, span))
    message = (
        f"{fit.actuator}: its commands, up to {np.abs(fit.drive[span]).max():.3g} at {fit.joint}, do nothing from "
        f"{begin:.2f} to {end:.2f} s, elsewhere they act (gain {best.gain:.2g})."
    )
    remedy = f"The machine seems off there. Take the parts of the log without it: {fit.log.name}[:{begin:.1f}]."
    return Fault("off", fit.log.name, fit.actuator, begin, end, message, remedy)


def _idle_span(fit: DriveFit, settings: FaultSettings) -> slice | None:
    """The span in which the motion needs no drive, whatever the commands say.

    A first gain comes from the whole log, or, where most of it may be idle, from its beginning or its end.
    """
    every = np.arange(len(fit.time)) / len(fit.time)
    for first in (every >= 0.0, every < _MOST_OF, every >= 1 - _MOST_OF):
        span = _refined(fit, first, settings)
        if span is not None and _surely_idle(fit, span, settings):
            return span
    return None


def _refined(fit: DriveFit, rows: Mask, settings: FaultSettings) -> slice | None:
    """The span that speaks most for idle commands, by gains of what lies outside of it."""
    least, span = settings.gain**0.5, None  # the span itself lowers the first gain
    for _ in range(_REFINEMENTS):
        _, driven, without = _readings(fit, least, rows)
        span = _largest(driven - without - 2 * driven[rows].mean())
        if span is None:
            return None
        rows = _outside(fit, span)
        if rows.mean() < 1 - _MOST_OF:
            return None
    return span


def _surely_idle(fit: DriveFit, span: slice, settings: FaultSettings) -> bool:
    rows = _outside(fit, span)
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


def _outside(fit: DriveFit, span: slice) -> Mask:
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


def _better(fit: DriveFit, other: Gain, given: Gain, settings: FaultSettings) -> bool:
    worth = given.left >= settings.share * float(fit.need @ fit.need)
    return worth and other.left <= settings.contrast * given.left


def _ratio(worse: Gain, better: Gain) -> str:
    return f"{worse.left / max(better.left, 1e-12 * worse.left):.2g}"


def _largest(score: Array) -> slice | None:
    """The run with the largest sum, None where no score is positive (Kadane)."""
    total = np.concatenate([[0.0], np.cumsum(score)])
    lowest = np.minimum.accumulate(total[:-1])
    end = int((total[1:] - lowest).argmax())
    if total[end + 1] - lowest[end] <= 0:
        return None
    start = int(total[: end + 1].argmin())
    return slice(start, end + 1)


def _whole(kind: str, fit: DriveFit, message: str, remedy: str) -> Fault:
    return Fault(kind, fit.log.name, fit.actuator, float(fit.time[0]), float(fit.time[-1]), message, remedy)
