"""Samples that break the data contract: not finite, out of order, missing, wrapped."""

from typing import NamedTuple

import numpy as np

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.row_numbers import RowNumbers
from dr_lab.trajectory import Array, Note

_TURN = 2 * np.pi
# A jump is so many times as large as all but a tenth of the steps between samples.
_APART, _USUAL = 10.0, 0.9
# The usual period is measured over this many samples, so that bursts of a slow network do not shorten it.
_BLOCK = 16
# Places by which a network reorders messages; a clock that is set back moves more.
_REORDERED = 16


class Cleaned(NamedTuple):
    """Samples of one channel after a step of cleaning, and what the step found."""

    time: Array
    value: Array
    notes: tuple[Note, ...]


def drop_not_finite(name: str, time: Array, value: Array, log: str = "", rows: RowNumbers | None = None) -> Cleaned:
    """Drop samples whose time or value (or a component of it) is NaN or infinite.

    Args:
        name: channel.
        time: shape (n,).
        value: shape (n,) or (n, k).
        log: whose channel it is, for messages.
        rows: where the samples of a table stand in its file, whose empty cells were read as NaN; None of messages.

    Raises:
        DataError: nothing is left.
    """
    timed = np.isfinite(time)
    good = timed & np.isfinite(value.reshape(len(value), -1)).all(axis=1)
    lost = int(len(good) - good.sum())
    what = "samples are NaN or infinite"
    if rows is not None:
        what = f"cells{'' if timed.all() else ', or those of their times,'} are empty or no finite numbers"
    if not good.any():
        where, place = f"Log {log!r}: channel" if log else "Channel", "topic" if rows is None else "column"
        raise DataError(f"{where} {name!r}: all {len(good)} {what}. Check its {place}.")
    if lost == 0:
        return Cleaned(time, value, ())
    at = "" if rows is None else f" ({rows.kept(~good)})"
    note = Note("nan", name, f"{name}: {lost} of {len(good)} {what}{at}; they were dropped.", lost)
    return Cleaned(time[good], value[good], (note,))


def drop_unordered(name: str, time: Array, value: Array, *, held: bool = False) -> Cleaned:
    """Make the times increase; report what stood in the way.

    Samples that came out of order over a few places (a network's reordering) are sorted. A longer step back is a clock
    that was set: the samples that lie before an earlier one are dropped. Of several at one time the first is kept.

    Args:
        name: channel.
        time: shape (n,).
        value: shape (n,) or (n, k).
        held: whether a value holds until the next; then the last of several at one time is kept, which holds from then.
    """
    if len(time) == 0:
        return Cleaned(time, value, ())
    order = np.argsort(time, kind="stable")
    moved = np.abs(order - np.arange(len(time)))
    notes = []
    if 0 < moved.max() <= _REORDERED:
        time, value = time[order], value[order]
        count = int((moved > 0).sum())
        notes.append(Note("reordered", name, f"{name}: {count} samples came out of order and were sorted.", count))
    latest = np.maximum.accumulate(time)
    before = np.concatenate([[-np.inf], latest[:-1]])
    back = time < before
    if back.any():
        count, far = int(back.sum()), float((before - time)[back].max())
        message = (
            f"{name}: time goes back by up to {far:.3g} s; the {count} samples before an earlier one were dropped."
        )
        notes.append(Note("back_steps", name, message, count))
    time, value = time[~back], value[~back]
    same = np.diff(time) == 0
    if same.any():
        count = int(same.sum())
        other = "are followed by another at the same time" if held else "repeat the time of an earlier one"
        notes.append(Note("duplicates", name, f"{name}: {count} samples {other} and were dropped.", count))
    keep = ~np.append(same, False) if held else ~np.append(False, same)
    return Cleaned(time[keep], value[keep], tuple(notes))


def period(time: Array) -> float:
    """Usual time between two samples in s: the median over blocks of samples, shape (n,), n ≥ 2."""
    block = min(_BLOCK, len(time) - 1)
    return float(np.median(time[block:] - time[:-block])) / block


def find_gaps(name: str, time: Array, contract: DataContract) -> tuple[Note, ...]:
    """Report times between two samples that are longer than `contract.gap` usual periods."""
    if len(time) < 3:
        return ()
    usual = period(time)
    waits = np.diff(time)
    count = int((waits > contract.gap * usual).sum())
    if count == 0:
        return ()
    longest = int(waits.argmax())
    message = (
        f"{name}: {count} gaps longer than {contract.gap:g} periods of {usual * 1e3:.3g} ms; the longest is "
        f"{waits[longest]:.3g} s at {time[longest]:.3g} s. No window reaches across them."
    )
    if count > contract.event_share * len(waits):
        message += " If it is published only when it changes, have it published at a steady rate."
    return (Note("gap", name, message, count),)


def longest_wait(times: list[Array], contract: DataContract, *, on_change: bool) -> float:
    """Longest time between two samples that is not a gap, over all logs, in s.

    Args:
        times: one array of sample times per log.
        contract: how many periods make a gap.
        on_change: whether the sender may have sent only changes; then a channel with many gaps has none (infinity).
    """
    times = [time for time in times if len(time) > 1]
    if not times:
        return float("inf")
    limit = contract.gap * max(period(time) for time in times)
    waits = np.concatenate([np.diff(time) for time in times])
    if on_change and (waits > limit).mean() > contract.event_share:
        return float("inf")
    return limit


def unwrap(name: str, value: Array, turn: float) -> Cleaned:
    """Undo jumps of values of shape (n,) or (n, k) by so much, in their unit; say so if they jump otherwise."""
    smooth = np.unwrap(value, period=turn, axis=0)
    count = int((np.abs(np.diff(smooth - value, axis=0)) > turn / 2).sum())
    jump = "a full turn" if turn == _TURN else f"{turn:.6g}"
    if count:
        return Cleaned(
            np.empty(0), smooth, (Note("wrapped", name, f"{name}: {count} jumps by {jump} were undone.", count),)
        )
    steps = np.abs(np.diff(value, axis=0))
    largest = float(steps.max(initial=0.0))
    if not largest > _APART * np.quantile(steps, _USUAL):
        return Cleaned(np.empty(0), smooth, ())
    message = (
        f"{name}: wrap is set, but nothing jumps by {jump}; the largest step between two samples is {largest:.4g}. "
        "Behind a gear ratio in scale an angle jumps by a full turn times that: give the jump as a number, wrap: JUMP."
    )
    return Cleaned(np.empty(0), smooth, (Note("wrap", name, message),))


def find_wraps(name: str, value: Array, contract: DataContract) -> tuple[Note, ...]:
    """Report an angle in rad that seems to wrap: jumps of nearly 2π from one sample to the next."""
    jumps = np.abs(np.abs(np.diff(value, axis=0)) - _TURN) < contract.wrap_tolerance * _TURN
    count = int(jumps.sum())
    if count == 0:
        return ()
    message = f"{name}: {count} jumps by about 2π look like an angle that wraps; set wrap: true for this channel."
    return (Note("wrap", name, message, count),)
