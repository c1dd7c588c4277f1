"""One file, or a stretch of it, to one `Log`: read, put on one clock, convert, clean."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dr_lab.errors import DataError
from dr_lab.measurements.cleaning import drop_not_finite, drop_unordered, find_gaps, find_wraps, longest_wait, unwrap
from dr_lab.measurements.constant import find_constant
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.glitches import drop_glitches
from dr_lab.measurements.log_file import stem
from dr_lab.measurements.noise import estimate_noise
from dr_lab.measurements.raw_log import RawChannel, RawLog, TimeAxis, held_since, read_raw
from dr_lab.measurements.recordings import Recording
from dr_lab.measurements.sampling import CLOCKS, check_sampling
from dr_lab.measurements.signal_map import channel_maps
from dr_lab.measurements.unit_check import check_units
from dr_lab.trajectory import Array, ClockFit, Log, Note, Signal

Mask = NDArray[np.bool_]
_QUATERNION = 4  # numbers


def read_log(
    path: Path,
    outputs: Mapping[str, Mapping[str, Any]],
    commands: Mapping[str, Mapping[str, Any]],
    contract: DataContract,
    clock: str = "",
    time: TimeAxis | None = None,
) -> Log:
    """Read one file.

    Args:
        path: a file or bag folder of one of the kinds of `dr_lab.measurements.log_file`.
        outputs: entries of the measured channels; see `dr_lab.measurements.signal_map.channel_map`.
        commands: entries of the commands.
        contract: thresholds.
        clock: default clock of all channels; ``""`` takes the file's own (log time, time column).
        time: time column and cut.

    Returns:
        The log, with its notes; times count from the file's first message or row.

    Raises:
        DataError: the file or a channel cannot be used; the message says why and what to do.
        UnknownNameError: a topic, field, joint or column that is not there.
    """
    raw = read_raw(
        Recording(path), channel_maps(outputs, clock), channel_maps(commands, clock), time or TimeAxis(), contract
    )
    return clean(raw, stem(path), -np.inf, np.inf, contract)


def clean(raw: RawLog, name: str, start: float, stop: float, contract: DataContract) -> Log:
    """Make a log of the seconds `start` to `stop` of a file.

    A command keeps its last sample before `start`, whose value holds until the next.

    Args:
        raw: the file's channels.
        name: the log's name.
        start: s.
        stop: s.
        contract: thresholds.

    Raises:
        DataError: a channel has no usable sample, commands and outputs do not overlap, or a unit seems wrong.
    """
    notes = list(raw.notes)
    outputs: dict[str, Signal] = {}
    commands: dict[str, Signal] = {}
    for part in raw.outputs:
        keep = ~((part.time < start) | (part.time > stop))
        clock = raw.clocks[part.channel.name].clock
        outputs[part.channel.name] = _output(part, keep, name, clock, notes, contract)
    for part in raw.commands:
        keep = ~((part.time < held_since(part.time, part.value, start)) | (part.time > stop))
        commands[part.channel.name] = _command(part, keep, name, notes, contract)
    _check_overlap(name, outputs, commands, raw.clocks)
    notes += check_units(outputs, [part.channel for part in raw.outputs], contract)
    notes += find_constant(outputs, commands)
    return Log(name, outputs, commands, tuple(notes), raw.clocks)


def _output(part: RawChannel, keep: Mask, log: str, clock: str, notes: list[Note], contract: DataContract) -> Signal:
    channel = part.channel
    time, value = _sound(_without_zeros(part, notes), keep, log, notes, held=False)
    if channel.wrap:
        _, smooth, found = unwrap(channel.name, value, channel.wrap)
        value = smooth + _turned_before(part, float(time[0]), value[0])
        notes += found
    elif channel.unit.name == "rad":
        notes += find_wraps(channel.name, value, contract)
    if len(time) < contract.minimum_samples:
        why = "".join(f" {note.message}" for note in notes if note.signal == channel.name)
        enough = int(keep.sum()) + part.missing >= contract.minimum_samples
        raise DataError(
            f"Log {log!r}: channel {channel.name!r} ({channel.source}) has {len(time)} usable samples; at least "
            f"{contract.minimum_samples} are needed.{why} "
            f"{'Mend that in the file' if enough else 'Give a longer log'}, or leave it out of logs."
        )
    check_sampling(f"Log {log!r}: channel {channel.name!r} ({channel.source})", time, clock, contract)
    signal = Signal(channel.name, channel.unit.name, time, value)
    wait = longest_wait([time], contract, on_change=False)
    if value.ndim == 1 and np.ptp(value) > 0.0:
        noise_std = channel.noise_std_si or estimate_noise([signal], wait, contract).std
        time, value, found = drop_glitches(channel.name, time, value, noise_std, wait, contract)
        notes += found
        signal = Signal(channel.name, channel.unit.name, time, value)
    notes += find_gaps(channel.name, time, contract)
    return signal


def _command(part: RawChannel, keep: Mask, log: str, notes: list[Note], contract: DataContract) -> Signal:
    time, value = _sound(part, keep, log, notes, held=True)
    if np.isfinite(longest_wait([time], contract, on_change=True)):
        notes += find_gaps(part.channel.name, time, contract)
    return Signal(part.channel.name, part.channel.unit.name, time, value, part.channel.between)


def _turned_before(part: RawChannel, time: float, value: Array) -> Array:
    """How far a file's jumps up to a sample, which has a time and value, carry it: all its stretches count the same."""
    wrap, earlier = part.channel.wrap, part.time <= time
    finite = drop_not_finite(part.channel.name, part.time[earlier], part.value[earlier])
    ordered = drop_unordered(part.channel.name, finite.time, finite.value)
    return wrap * np.rint((np.unwrap(ordered.value, period=wrap, axis=0)[-1] - value) / wrap)


def _without_zeros(part: RawChannel, notes: list[Note]) -> RawChannel:
    """The channel, whose quaternions of zeros, of a tracker that lost its body, are not a number."""
    if part.value.ndim != 2 or part.value.shape[1] != _QUATERNION or part.channel.unit.name != "1":
        return part
    lost = np.all(part.value == 0.0, axis=1)
    if not lost.any() or lost.all():
        return part
    name, count = part.channel.name, int(lost.sum())
    notes.append(Note("no_orientation", name, f"{name}: {count} samples are all zeros, no orientation.", count))
    return replace(part, value=np.where(lost[:, None], np.nan, part.value))


def _sound(part: RawChannel, keep: Mask, log: str, notes: list[Note], *, held: bool) -> tuple[Array, Array]:
    """Finite samples in the order of time."""
    name = part.channel.name
    if not keep.any():
        known = part.time[np.isfinite(part.time)]
        lie = (
            f"they lie from {known.min():.6g} to {known.max():.6g} s" if len(known) else "time.start and stop left none"
        )
        raise DataError(
            f"Log {log!r}: channel {name!r} ({part.channel.source}) has no sample in the chosen time; {lie}. Choose "
            "others, or leave it out of logs."
        )
    if part.missing:
        message = f"{name}: {part.missing} messages of {part.channel.topic} do not hold it."
        notes.append(Note("partial", name, message, part.missing))
    rows = part.rows and part.rows.kept(keep)
    finite = drop_not_finite(name, part.time[keep], part.value[keep], log, rows)
    ordered = drop_unordered(name, finite.time, finite.value, held=held)
    notes += [*finite.notes, *ordered.notes]
    return ordered.time, ordered.value


def _check_overlap(
    log: str, outputs: Mapping[str, Signal], commands: Mapping[str, Signal], clocks: Mapping[str, ClockFit]
) -> None:
    for command in commands.values():
        for output in outputs.values():
            if command.time[0] > output.time[-1] or (command.time[-1] < output.time[0] and len(command) > 1):
                hint = _clock_hint(clocks[command.name].clock, clocks[output.name].clock)
                raise DataError(
                    f"Log {log!r}: {_span(command)} and {_span(output)} do not overlap in time. {hint}Record them "
                    "together, or leave the log out."
                )


def _clock_hint(*pair: str) -> str:
    if pair in (("log", "log"), ("column", "column")):  # one clock; those of headers and publishers may be several
        return ""
    others = " or ".join(clock for clock in CLOCKS if {clock} != {*pair})
    return f"If their clocks ({' and '.join(pair)}) do not agree, choose another clock for one of them: {others}. "


def _span(signal: Signal) -> str:
    return f"{signal.name!r} ({signal.time[0]:.6g} to {signal.time[-1]:.6g} s)"
