"""Logs cut into windows: what is simulated from each start, under which controls, compared with which samples."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.activations import Activations, activations, run_in_of
from dr_lab.diagnosis.windows.blocks import spread
from dr_lab.diagnosis.windows.channels import Channel, require_numbers, resolve
from dr_lab.diagnosis.windows.commands import actuator_columns, averages
from dr_lab.diagnosis.windows.local_fits import starts_known
from dr_lab.diagnosis.windows.start import Before, estimate_starts, motion_before
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.unlogged import Unlogged, unlogged
from dr_lab.errors import DataError
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class WindowSamples:
    """Samples of one channel in w windows, padded to m columns.

    Attributes:
        channel: the channel.
        std: noise of the residual, of orientations in rad: twice that of the quaternion's components.
        time: s after the window's simulated start, shape (w, m).
        value: measured values, shape (w, m, raw size).
        fitted: samples that estimate starts and parameters, shape (w, m).
        scored: samples that count in the score, shape (w, m).
    """

    channel: Channel
    std: float
    time: Array
    value: Array
    fitted: Mask
    scored: Mask

    def pick(self, rows: NDArray[np.intp]) -> "WindowSamples":
        """The samples of some windows."""
        kept = {name: getattr(self, name)[rows] for name in ("time", "value", "fitted", "scored")}
        return replace(self, **kept)


@dataclass(frozen=True)
class Windows:
    """Everything a replay needs of the data.

    Attributes:
        log: index of each window's log in `logs`, shape (w,).
        logs: names of the logs that hold a window.
        loaded: whether a load may have been attached, shape (w,).
        begin: time on the log's clock at which the simulation of the window starts, shape (w,).
        samples: the channels' samples.
        controls: control of each step in the nominal model's ctrl layout, shape (w, s, nu).
        past: controls of the steps before the start, shape (w, p, nu).
        before: motion and controls in the steps before the start that laws and actuators remember.
        activations: what is known of the actuators' activations; None where the model has none.
        unlogged: what commands may have done between their samples; None where that is known.
        commands: column in `ctrl` of each command.
        prior: first estimate of the start and how far it may be wrong.
        step: s, time step of the simulation.
        margin: s, time simulated beyond the samples at either end.
        length: s, scored time of each.
    """

    log: NDArray[np.intp]
    logs: tuple[str, ...]
    loaded: Mask
    begin: Array
    samples: tuple[WindowSamples, ...]
    controls: Array
    past: Array
    before: Before
    activations: Activations | None
    unlogged: Unlogged | None
    commands: Mapping[str, int]
    prior: StartPrior
    step: float
    margin: float
    length: float

    def __len__(self) -> int:
        """Number of windows."""
        return len(self.begin)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the measured channels."""
        return tuple(samples.channel.name for samples in self.samples)

    def pick(self, rows: NDArray[np.intp]) -> "Windows":
        """Some of the windows; `logs` stays, so that indices of logs keep their meaning."""
        return replace(
            self,
            log=self.log[rows],
            loaded=self.loaded[rows],
            begin=self.begin[rows],
            samples=tuple(samples.pick(rows) for samples in self.samples),
            controls=self.controls[rows],
            past=self.past[rows],
            before=self.before.pick(rows),
            activations=self.activations and self.activations.pick(rows),
            unlogged=self.unlogged and self.unlogged.pick(rows),
            prior=self.prior.pick(rows),
        )


def cut(logs: Sequence[Log], measured: MeasurementSet, model: mujoco.MjModel, settings: WindowSettings) -> Windows:
    """Cut logs into windows for a model; a log without room for one is left out.

    Args:
        logs: the logs to cut (a part of `measured`).
        measured: gives noise and gap lengths.
        model: compiled nominal model.
        settings: how to cut.

    Raises:
        DataError: no log is long enough for one window, or no sample falls into one.
        UnknownNameError: a channel or command is not in the model.
    """
    logs, begins = _windowed(logs, measured.gaps, settings, run_in_of(model, settings))
    return windows_at(logs, begins, measured, model, settings)


def windows_at(
    logs: Sequence[Log],
    begins: Sequence[Array],
    measured: MeasurementSet,
    model: mujoco.MjModel,
    settings: WindowSettings,
) -> Windows:
    """Windows whose simulations start at given times.

    Args: as `cut`, and
        begins: s on each log's clock, at least one for each.

    Raises: as `cut`, but for logs that are too short.
    """
    columns, samples = actuator_columns(model, logs), _all_samples(model, logs, begins, measured, settings)
    nstep, npast, nback = _step_counts(model, settings)
    first, pairs = max(npast, nback), zip(logs, begins, strict=True)
    edges = model.opt.timestep * np.arange(-first, nstep + 1)
    steps = np.concatenate([averages(log.commands, columns, model.nu, b[:, None] + edges) for log, b in pairs])
    before = motion_before(logs, begins, model, steps[:, first - nback : first], settings)
    prior = estimate_starts(logs, begins, model, measured.noise, settings)
    hidden = activations(logs, begins, model, before, prior, settings)
    missing = unlogged(logs, begins, columns, edges[first:], settings.most_unlogged)
    return Windows(
        log=np.repeat(np.arange(len(logs)), [len(b) for b in begins]),
        logs=tuple(log.name for log in logs),
        loaded=np.repeat([log.loaded for log in logs], [len(b) for b in begins]),
        begin=np.concatenate(begins),
        samples=samples,
        controls=steps[:, first:],
        past=steps[:, first - npast : first],
        before=before,
        activations=hidden,
        unlogged=missing,
        commands=columns,
        prior=_with_hidden(prior, hidden, missing),
        step=model.opt.timestep,
        margin=settings.margin,
        length=settings.length,
    )


def _with_hidden(prior: StartPrior, hidden: Activations | None, missing: Unlogged | None) -> StartPrior:
    """The prior with what is not known of activations, and of commands between their samples."""
    of_commands = np.ones(0 if missing is None else missing.column.shape[1])
    return replace(prior, std=np.concatenate([prior.std, np.zeros(0) if hidden is None else hidden.std, of_commands]))


def _step_counts(model: mujoco.MjModel, settings: WindowSettings) -> tuple[int, int, int]:
    """Simulation steps of a window, of the commands before it, and of the motion before it."""
    total = settings.run_in + settings.length + 2 * settings.margin
    spans = (total, max(settings.past, settings.kept), max(settings.memory, run_in_of(model, settings)))
    nstep, npast, nback = (int(np.ceil(span / model.opt.timestep)) for span in spans)
    return nstep + 1, npast, nback


def _windowed(
    logs: Sequence[Log], gaps: Mapping[str, float], settings: WindowSettings, run_in: float
) -> tuple[list[Log], list[Array]]:
    """Logs that hold a window, and the simulated starts in each: where there is room, behind the actuators' run-in."""
    late = replace(settings, past=max(settings.past, run_in))
    begins = [window_begins(log, gaps, late) for log in logs]
    if run_in > settings.past:
        begins = [b if len(b) else window_begins(log, gaps, settings) for log, b in zip(logs, begins, strict=True)]
    kept = [k for k, b in enumerate(begins) if len(b)]
    counts = _shares([len(begins[k]) for k in kept], settings.most)
    if not kept:
        need = settings.length + settings.run_in + 2 * settings.margin
        spans = (_span(log, settings.past) for log in logs)
        listed = ", ".join(f"{log.name} {last - first:.3g} s" for log, (first, last) in zip(logs, spans, strict=True))
        broken = [f" In {log.name} {note.message}" for log in logs for note in log.notes if note.kind == "gap"]
        raise DataError(
            f"No log holds one gapless window of {need:.3g} s behind {settings.past:g} s of commands (logs: {listed})."
            f"{''.join(broken[:1])} Shorten windows.length or give longer logs{' or some without gaps' * bool(broken)}."
        )
    chosen = [begins[k][spread(len(begins[k]), count)] for k, count in zip(kept, counts, strict=True)]
    return [logs[k] for k in kept], chosen


def _shares(counts: Sequence[int], most: int) -> list[int]:
    """How many windows each log gives: as many as any other, or all that it has, `most` together; one at least."""
    given, left = [0] * len(counts), most
    for done, k in enumerate(sorted(range(len(counts)), key=counts.__getitem__)):
        given[k] = min(counts[k], max(1, round(left / (len(counts) - done))))
        left -= given[k]
    return given


def _span(log: Log, past: float) -> tuple[float, float]:
    """Time covered by every channel and behind enough commands; commands hold their last value."""
    starts = [s.time[0] for s in log.outputs.values()] + [s.time[0] + past for s in log.commands.values()]
    return max(starts), min(s.time[-1] for s in log.outputs.values())


def window_begins(log: Log, gaps: Mapping[str, float], settings: WindowSettings) -> Array:
    """Simulated starts of all windows of a log that no gap touches.

    Args:
        log: the log; every signal has a sample.
        gaps: longest time in s between two samples that is not a gap, by channel.
        settings: how to cut.

    Returns:
        Times on the log's clock in s, shape (w,); none where the log has no room for a window.
    """
    first, last = _span(log, settings.past)
    total = settings.run_in + settings.length + 2 * settings.margin
    waits = {name: gaps.get(name, np.inf) for name in log.commands}
    last = min([last, *(signal.time[-1] + waits[name] for name, signal in log.commands.items())])  # held until then
    begins = np.arange(first, last - total, settings.length)
    for name, signal in log.outputs.items():
        begins = begins[_gapless(begins, total, signal.time, gaps[name])]
        begins = begins[starts_known(signal, begins, settings)]
    for name, signal in log.commands.items():  # delayed actuators ask for those of before the start
        begins = begins[_gapless(begins - settings.past, total + settings.past, signal.time, waits[name])]
    return begins


def _gapless(begins: Array, total: float, time: Array, gap: float) -> NDArray[np.bool_]:
    """Which stretches of so many seconds touch no hole between samples that is longer than the gap."""
    holes = np.flatnonzero(np.diff(time) > gap)
    left, right = time[holes], time[holes + 1]
    return np.all((begins[:, None] + total < left) | (begins[:, None] > right), axis=1)


def _all_samples(
    model: mujoco.MjModel,
    logs: Sequence[Log],
    begins: Sequence[Array],
    measured: MeasurementSet,
    settings: WindowSettings,
) -> tuple[WindowSamples, ...]:
    """The samples of every channel in all windows."""
    samples = tuple(
        _samples(channel, logs, begins, measured.noise[channel.name], settings)
        for channel in resolve(model, tuple(logs[0].outputs))
    )
    if not any(part.scored.any() for part in samples):
        raise DataError(f"No sample falls into a window of {settings.length:g} s. Lengthen windows.length.")
    return samples


def _samples(
    channel: Channel, logs: Sequence[Log], begins: Sequence[Array], noise: Noise, settings: WindowSettings
) -> WindowSamples:
    """Pad the samples of one channel in all windows to one width."""
    for log in logs:
        require_numbers(channel, log)
    lead, signals = settings.margin + settings.run_in, [log.outputs[channel.name] for log in logs]
    first = np.cumsum([0, *map(len, signals)])  # of each log's samples among those of all
    cuts = [
        offset + np.searchsorted(signal.time, np.stack([b + settings.margin, b + lead, b + lead + settings.length], 1))
        for offset, signal, b in zip(first[:-1], signals, begins, strict=True)
    ]
    start, middle, stop = np.concatenate(cuts).T[..., None]
    column = np.arange(int((stop - start).max()))
    index, inside = np.minimum(start + column, first[-1] - 1), column < stop - start
    every = np.concatenate([signal.time for signal in signals])[index] - np.concatenate(begins)[:, None]
    raw = channel.numbers
    measured = np.concatenate([signal.value.reshape(len(signal), raw) for signal in signals])[index]
    nothing = np.eye(raw)[0] if channel.kind == "orientation" else np.zeros(raw)
    time, value = np.where(inside, every, 0.0), np.where(inside[..., None], measured, nothing)
    known = column < middle - start
    scored = inside & ~known
    std = noise.std * (2.0 if channel.kind == "orientation" else 1.0)  # a turn by φ moves a unit quaternion by φ/2
    return WindowSamples(channel, std, time, value, known if settings.run_in > 0 else scored, scored)
