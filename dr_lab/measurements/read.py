"""A ``measurements`` configuration to a `MeasurementSet`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from dr_lab.errors import ConfigError
from dr_lab.measurements.cleaning import longest_wait
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.derived_velocity import without_derived
from dr_lab.measurements.even_times import on_even_times
from dr_lab.measurements.faults.find import mark_faults
from dr_lab.measurements.log import clean
from dr_lab.measurements.noise import estimate_noise
from dr_lab.measurements.raw_log import RawLog, TimeAxis, read_raw
from dr_lab.measurements.recordings import Recording, recordings
from dr_lab.measurements.signal_map import ChannelMap, channel_maps
from dr_lab.measurements.split import Part, find_files, named, split
from dr_lab.trajectory import Log, MeasurementSet, Noise

Entries = Mapping[str, Mapping[str, Any]]


def read(
    name: str,
    logs: Sequence[str],
    outputs: Entries,
    contract: DataContract,
    commands: Entries | None = None,
    fit: Sequence[str] | None = None,
    held_out: Sequence[str] | None = None,
    clock: str | None = None,
    time: Mapping[str, Any] | None = None,
    group: str | None = None,
    loaded: Sequence[str] | None = None,
) -> MeasurementSet:
    """Read all logs of one machine.

    Args:
        name: of the configuration.
        logs: files, globs, or folders with logs of one kind, of those of `dr_lab.measurements.log_file`; only those
            that `fit` or `held_out` name are read.
        outputs: measured channels by name; see `dr_lab.measurements.signal_map.channel_map`.
        contract: thresholds of the data contract.
        commands: commands by actuator name, in the same form; None for a machine that swings freely.
        fit: logs to fit on, ``stem`` or ``stem[a:b]`` in s, wildcards ``*``, ``?``, ``[05]``; None: all not held out.
        held_out: logs never fitted; None holds nothing out.
        clock: default clock of all channels, ``header``, ``publish``, ``log`` or ``column``; None takes the file's own.
        time: for tables ``column``, ``unit`` and ``scale`` of the time, and for any log ``start`` and ``stop`` in s.
        group: column of tables that hold several logs each, called ``stem/value``; see `recordings.recordings`.
        loaded: logs during which a load was attached that the others lack, wildcards as for `fit`; what effects attach
            to the machine is absent from the others. None: that is not known, and they act in all logs.

    Returns:
        The logs; per channel one noise std pooled over all logs and the longest wait that is not a gap. Velocities that
        were made of the logged positions are left out, which a note on each log says.

    Raises:
        DataError: a file or channel that cannot be used.
        UnknownNameError: a log, topic, field, joint, column or key that does not exist; the message lists the others.
        ConfigError: the configuration contradicts itself.
    """
    measured, sent = _channels(name, outputs, clock), channel_maps(commands or {}, clock or "")
    known = recordings(find_files(logs), group)
    fitted, scored = split(known, fit, held_out)
    carrying = frozenset(known) if loaded is None else named(loaded, known)
    parts = _load((*fitted, *scored), known, measured, sent, _time_axis(name, time or {}), contract)
    every = [replace(log, loaded=part.log in carrying) for log, part in zip(parts, (*fitted, *scored), strict=True)]
    wraps = {channel.name: channel.wrap for channel in measured if channel.wrap}
    even = on_even_times(every, contract)
    fit_logs, held_out_logs = mark_faults(even[: len(fitted)], even[len(fitted) :], contract, wraps)
    noise, waits = _pooled(measured, sent, fit_logs + held_out_logs, contract)
    return _without_derived(MeasurementSet(name, fit_logs, held_out_logs, noise, waits), contract)


def _without_derived(found: MeasurementSet, contract: DataContract) -> MeasurementSet:
    """The logs without velocities that were made of their positions."""
    logs, made = without_derived(found.fit + found.held_out, found.noise, contract)
    noise = {channel: one for channel, one in found.noise.items() if channel not in made}
    gaps = {channel: wait for channel, wait in found.gaps.items() if channel not in made}
    return MeasurementSet(found.name, logs[: len(found.fit)], logs[len(found.fit) :], noise, gaps)


def _channels(name: str, outputs: Entries, clock: str | None) -> tuple[ChannelMap, ...]:
    if not outputs:
        raise ConfigError(f"Measurements {name!r} name no outputs; give at least one measured channel.")
    maps = channel_maps(outputs, clock or "")
    for channel in maps:
        if channel.between:
            raise ConfigError(
                f"Channel {channel.name!r}: between is for commands; a measured channel is known at its samples alone. "
                "Leave it out."
            )
    return maps


def _load(
    parts: Sequence[Part],
    known: Mapping[str, Recording],
    measured: Sequence[ChannelMap],
    sent: Sequence[ChannelMap],
    axis: TimeAxis,
    contract: DataContract,
) -> tuple[Log, ...]:
    """Read each recording once, whatever the number of its parts."""
    raw: dict[str, RawLog] = {}
    for part in parts:
        if part.log not in raw:
            raw[part.log] = read_raw(known[part.log], measured, sent, axis, contract)
    return tuple(clean(raw[part.log], part.name, part.start, part.stop, contract) for part in parts)


def _pooled(
    measured: Sequence[ChannelMap], sent: Sequence[ChannelMap], logs: Sequence[Log], contract: DataContract
) -> tuple[dict[str, Noise], dict[str, float]]:
    """Noise of each measured channel, and the longest wait of each channel that is not a gap."""
    waits = {c.name: longest_wait([g.outputs[c.name].time for g in logs], contract, on_change=False) for c in measured}
    held = {c.name: longest_wait([g.commands[c.name].time for g in logs], contract, on_change=True) for c in sent}
    return {c.name: _noise(c, logs, waits[c.name], contract) for c in measured}, waits | held


def _noise(channel: ChannelMap, logs: Sequence[Log], wait: float, contract: DataContract) -> Noise:
    if channel.noise_std_si is not None:
        return Noise(channel.noise_std_si, channel.unit.name, "given")
    return estimate_noise([log.outputs[channel.name] for log in logs], wait, contract)


def _time_axis(name: str, settings: Mapping[str, Any]) -> TimeAxis:
    known = ("column", "unit", "scale", "start", "stop")
    unknown = [key for key in settings if key not in known]
    if unknown:
        raise ConfigError(f"Measurements {name!r}: time has no key {unknown[0]!r}; it has {', '.join(known)}.")
    return TimeAxis(**{key: value for key, value in settings.items() if value is not None})
