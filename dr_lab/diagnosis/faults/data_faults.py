"""Faults of logs that a model shows: commands of the wrong sign or unit or out of step, machines off or held."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from dr_lab.diagnosis.faults.drive_fit import DriveFit, Forces, Gain
from dr_lab.diagnosis.faults.exchanged_commands import exchanged_commands
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.faults.fault_words import (
    factor_words,
    misread_position,
    parts_outside,
    remedy_of_factor,
    remedy_of_sign,
)
from dr_lab.diagnosis.faults.held_span import HeldSpan, held_spans
from dr_lab.diagnosis.faults.idle_span import idle_span, outside
from dr_lab.diagnosis.faults.misread import Misreading, misread
from dr_lab.diagnosis.faults.smoothed_motion import Mask
from dr_lab.trajectory import Log, MeasurementSet


@dataclass(frozen=True)
class Fault:
    """What seems wrong with a log.

    Attributes:
        kind: ``"sign"``, ``"unit"``, ``"swapped"``, ``"shift"``, ``"off"``, ``"decimated"`` or ``"held"``.
        log: the log's name.
        signal: the command's, the joint's that is held, or the channel that is misread.
        begin: s on the log's clock.
        end: s.
        message: what was seen, with figures.
        remedy: what to write or to do.
        rest: name of the stretch of the log without what is held; empty of other kinds.
    """

    kind: str
    log: str
    signal: str
    begin: float
    end: float
    message: str
    remedy: str
    rest: str = ""


def suspect_faults(forces: Forces | None, measured: MeasurementSet) -> tuple[Fault, ...]:
    """Test all logs by inverse dynamics of the nominal model: commands against the motion that they made, and rest.

    Of each actuator and log the drive is regressed on what the joint's motion needs, beside friction, a spring, an
    offset and the errors that a nominal model may have. A fault is told where another reading of the commands (another
    sign, a factor, a shift in time, none at all) leaves far fewer squares than the given one with any plausible gain.
    A joint that rests at a log's beginning or end where it would move is told, too (`held_spans`). Where one channel in
    another unit, or two exchanged, would explain all logs far better (`misread`, `exchanged_commands`), nothing else is
    told: it would follow from that.

    Args:
        forces: of all logs, by the model as given; None where nothing can be tested.
        measured: all logs.

    Returns:
        The faults, log by log.
    """
    if forces is None:
        return ()
    settings = forces.settings
    if (other := misread(forces, measured) or exchanged_commands(forces, measured)) is not None:
        return tuple(_of_log(other, log) for log in forces.logs)
    drives = forces.drives()
    driven = _agreed([(fit, fault) for fit in drives for fault in _faults(fit, settings)], drives, settings)
    told = {(fit.log.name, fit.joint) for fit, _ in driven}  # commands that do nothing look like a hand against them
    sound = (fit for fit in forces.undriven() if (fit.log.name, fit.joint) not in told)
    held = (
        _held(fit, span, settings) for fit in sound for span in held_spans(fit, forces.friction(fit.joint), settings)
    )
    return (*(fault for _, fault in driven), *held)


def _of_log(other: Misreading, log: Log) -> Fault:
    """A misreading of all logs as a fault of one of them, from its first sample to its last."""
    begin = min(float(signal.time[0]) for signal in log.outputs.values())
    end = max(float(signal.time[-1]) for signal in log.outputs.values())
    return Fault(other.kind, log.name, other.signal, begin, end, other.message, other.remedy)


def _agreed(
    driven: Sequence[tuple[DriveFit, Fault]], drives: Sequence[DriveFit], settings: FaultSettings
) -> list[tuple[DriveFit, Fault]]:
    """The faults without a sign that one log shows, where in most others the commands act with neither sign."""
    kept = []
    for fit, fault in driven:
        others = [each for each in drives if each.actuator == fit.actuator and each.log is not fit.log]
        if fault.kind != "sign" or 2 * sum(_knows_sign(each, settings) for each in others) >= len(others):
            kept.append((fit, fault))
    return kept


def _knows_sign(fit: DriveFit, settings: FaultSettings) -> bool:
    """Whether a log's commands act, with the given sign or the other."""
    most = settings.contrast * fit.gain(0.0, 0.0).left
    bands = ((settings.gain, 1 / settings.gain), (-1 / settings.gain, -settings.gain))
    return any(fit.gain(*band).left <= most for band in bands)


def _faults(fit: DriveFit, settings: FaultSettings) -> list[Fault]:
    """At most one fault of a command in a log."""
    given = fit.gain(settings.gain, 1 / settings.gain)
    idle = fit.gain(0.0, 0.0)
    for test in (_sign, _unit, _off, _shift, _coarse):
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
    remedy = f"{remedy_of_sign(fit.actuator)} Or turn the sign of {fit.joint}'s channels."
    return _whole("sign", fit, message, remedy)


def _unit(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    bounds = ((1 / settings.gain, np.inf), (0.0, settings.gain), (-np.inf, -1 / settings.gain), (-settings.gain, 0.0))
    other = min((fit.gain(low, high) for low, high in bounds), key=lambda gain: gain.left)
    if not _better(fit, other, given, settings) or other.left >= settings.contrast * idle.left:
        return None
    message = (
        f"{fit.actuator}: the motion of {fit.joint} asks for {other.gain:.3g} times the commands' force"
        f"{factor_words(other.gain, settings.near_unit, fit.log.commands[fit.actuator].unit)}."
    )
    channel = f"{fit.joint}.position"
    unit = fit.log.outputs[channel].unit if channel in fit.log.outputs else ""
    beside = misread_position(other.gain, settings.near_unit, channel, unit)
    return _whole("unit", fit, message, f"{remedy_of_factor(fit.actuator, other.gain)}{beside}")


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
    if best.late.left > settings.contrast * fit.gain(0.0, 0.0, best.rows).left or _repeats(tried, best, settings):
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


def _repeats(tried: Sequence[_Shifted], best: _Shifted, settings: FaultSettings) -> bool:
    """Whether lags behind worse ones do about as well as the best: commands that repeat tell no shift, but a phase."""
    good = np.array([found.share * settings.contrast <= best.share for found in tried])
    return int(np.count_nonzero(good[1:] & ~good[:-1])) + int(good[0]) > 1


def _shifted(fit: DriveFit, lag: float, settings: FaultSettings) -> _Shifted | None:
    """Both readings; None where a log has too few test functions that know the later commands."""
    drive, rows = fit.late(lag)
    if rows.sum() < settings.known * len(rows):
        return None
    bounds = (settings.gain, 1 / settings.gain)
    return _Shifted(lag, fit.gain(*bounds, rows, drive), fit.gain(*bounds, rows), rows)


def _coarse(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    """Commands that changed between the samples of their log: the motion follows lines through them, not steps."""
    period = fit.log.commands[fit.actuator].wait
    if fit.straight is None or not settings.is_coarse(period) or given.left > settings.contrast * idle.left:
        return None
    lags = np.arange(0.0, settings.longest_delay, fit.step)
    held = min(found.share for lag in lags if (found := _shifted(fit, float(lag), settings)) is not None)
    line = fit.gain(settings.gain, 1 / settings.gain, drive=fit.straight)
    if line.left > settings.straight * held * given.left:
        return None
    message = (
        f"{fit.actuator}: logged every {1e3 * period:.3g} ms, but the motion of {fit.joint} follows straight lines "
        f"between its samples; commands that hold until the next sample, as they are read, leave {_ratio(given, line)} "
        "times the squares. It seems to change more often than it is logged, or its stamps are half of that late."
    )
    remedy = f"Log every command that is sent; read as it is, {fit.actuator} seems {500 * period:.3g} ms late."
    return _whole("decimated", fit, message, remedy)


def _off(fit: DriveFit, given: Gain, idle: Gain, settings: FaultSettings) -> Fault | None:
    """A span in which commands do nothing, though they act outside of it; or the whole log."""
    if _better(fit, idle, given, settings):
        message = f"{fit.actuator}: its commands do nothing to {fit.joint} in the whole log."
        return _whole("off", fit, message, f"Was the machine on? Leave the log out, or name {fit.actuator}'s channel.")
    span = idle_span(fit, settings)
    if span is None:
        return None
    best = fit.gain(settings.gain, 1 / settings.gain, outside(fit, span))
    strength = 100 * np.abs(fit.drive[span]).max() / np.abs(fit.drive).max()
    message = (
        f"{fit.actuator}: its commands, up to {strength:.0f} % of the log's largest, do nothing to {fit.joint}; "
        f"elsewhere they act (gain {best.gain:.2g})."
    )
    begin, end = float(fit.time[span][0]), float(fit.time[span][-1])
    reach, enough = settings.equation.half_width, settings.fewest
    before = begin - reach if span.start >= enough else None
    behind = end + reach if len(fit.time) - span.stop >= enough else None
    rest = parts_outside(fit.log.name, before, behind)
    remedy = "The machine seems off there. " + (f"Take the log without it: {rest}." if rest else "Leave the log out.")
    begin, end = (begin if span.start else begin - reach), (end if span.stop < len(fit.time) else end + reach)
    return Fault("off", fit.log.name, fit.actuator, begin, end, message, remedy)


def _held(fit: DriveFit, span: HeldSpan, settings: FaultSettings) -> Fault:
    reach = settings.equation.half_width
    begin, end = float(fit.time[span.rows][0]) - reach, float(fit.time[span.rows][-1]) + reach
    message = (
        f"{fit.joint} rests although {span.force:.2g} N·m (N of a slide) would move it, and the friction of its "
        f"motion, {span.friction:.2g}, cannot hold that. It seems to be held, by hand, a brake or a stop."
    )
    first = span.rows.start == 0
    rest = parts_outside(fit.log.name, None if first else begin, end if first else None)
    return Fault("held", fit.log.name, fit.joint, begin, end, message, f"Take the log without it: {rest}.", rest)


def _better(fit: DriveFit, other: Gain, given: Gain, settings: FaultSettings) -> bool:
    worth = given.left >= settings.share * float(fit.need @ fit.need)
    return worth and other.left <= settings.contrast * given.left


def _ratio(worse: Gain, better: Gain) -> str:
    return f"{worse.left / max(better.left, 1e-12 * worse.left):.2g}"


def _whole(kind: str, fit: DriveFit, message: str, remedy: str) -> Fault:
    return Fault(kind, fit.log.name, fit.actuator, float(fit.time[0]), float(fit.time[-1]), message, remedy)
