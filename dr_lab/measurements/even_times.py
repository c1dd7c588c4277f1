"""Stamps that scatter about an even clock, though the samples were taken evenly: the motion tells which it was."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import savgol_filter

from dr_lab.measurements.cleaning import longest_wait
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.noise import estimate_noise
from dr_lab.trajectory import Array, Log, Note, Signal

_NEAR = 25  # samples either way whose stamps tell when one was taken; it is known seven times as well as stamped
_SHARED = 0.9  # of a signal's stamps that are those of another one's rows
_EXACT = 1e-4  # of the time between samples; what rounding of stamps leaves is no scatter
_UNHARMED = 0.98  # least of the noise by the stamps over that on even times, in any channel


def on_even_times(logs: Sequence[Log], contract: DataContract) -> tuple[Log, ...]:
    """The logs on even times where the measured motion follows these and not the stamps, with a note in each.

    A program that reads a controller stamps each sample when it comes to it, by chance late or early by τ. Where the
    machine moves at v that looks like noise of v τ, the more the faster it moves. Even times are local straight lines
    through the stamps. They are taken if a channel is `contract.jitter` times as noisy by the stamps as on them, and
    none is less noisy by the stamps: samples that were taken unevenly and stamped well would show that. What comes in
    the same rows, commands among them, gets the same times.

    Args:
        logs: all logs; one program recorded them.
        contract: `jitter`; infinite keeps the stamps.
    """
    if not np.isfinite(contract.jitter):
        return tuple(logs)
    even = [_even(log, contract) for log in logs]
    names = [name for name in logs[0].outputs if all(name in log.outputs for log in logs)]
    moving = [
        n
        for n in names
        if any(_differ(a, b, n) and np.ptp(a.outputs[n].value) > 0.0 for a, b in zip(logs, even, strict=True))
    ]
    noisier = {name: _noise(logs, name, contract) / _noise(even, name, contract) for name in moving}
    if not noisier or max(noisier.values()) < contract.jitter or min(noisier.values()) < _UNHARMED:
        return tuple(logs)
    name = max(noisier, key=lambda each: noisier[each])
    scatter = float(
        np.median([np.std(a.outputs[name].time - b.outputs[name].time) for a, b in zip(logs, even, strict=True)])
    )
    message = (
        f"The stamps scatter by {1e3 * scatter:.2g} ms about an even clock, and the motion does not follow them: "
        f"by the stamps {name} is {noisier[name]:.2g} times as noisy as on even times. It is read on these, and so is "
        "what was logged in the same rows; measurements.contract.jitter=inf keeps the stamps."
    )
    return tuple(replace(log, notes=(*log.notes, Note("jitter", "", message))) for log in even)


def straightened(time: Array, contract: DataContract) -> Array:
    """Local lines through stamps, (n,), where these are even but for a scatter; elsewhere the stamps.

    Args:
        time: s, increasing, shape (n,).
        contract: `gap` usual periods without a sample end a stretch.
    """
    period = float(np.median(np.diff(time)))
    ends = np.flatnonzero(np.diff(time) > contract.gap * period) + 1
    return np.concatenate([_line(part, period) for part in np.split(time, ends)])


def _line(time: Array, period: float) -> Array:
    width = 2 * _NEAR + 1
    if len(time) < width:
        return time
    place = np.append(0.0, np.cumsum(np.rint(np.diff(time) / period)))
    late = time - place * period
    found = place * period + np.asarray(savgol_filter(late, width, 1), np.float64)
    even = (np.diff(place) >= 1).all() and (np.diff(found) > 0).all()
    return found if even and np.std(time - found) > _EXACT * period else time


def _even(log: Log, contract: DataContract) -> Log:
    base = max((signal.time for signal in log.outputs.values()), key=len)
    even = straightened(base, contract)

    def moved(signal: Signal) -> Signal:
        place = np.minimum(np.searchsorted(base, signal.time), len(base) - 1)
        same = base[place] == signal.time
        if same.mean() < _SHARED:
            return signal
        time = np.where(same, even[place], signal.time)
        return replace(signal, time=time) if (np.diff(time) > 0).all() else signal

    outputs, commands = ({n: moved(s) for n, s in part.items()} for part in (log.outputs, log.commands))
    return replace(log, outputs=outputs, commands=commands)


def _differ(one: Log, other: Log, name: str) -> bool:
    return not np.array_equal(one.outputs[name].time, other.outputs[name].time)


def _noise(logs: Sequence[Log], name: str, contract: DataContract) -> float:
    signals = [log.outputs[name] for log in logs if np.ptp(log.outputs[name].value) > 0.0]
    return estimate_noise(signals, longest_wait([s.time for s in signals], contract, on_change=False), contract).std
