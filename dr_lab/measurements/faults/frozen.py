"""Sensors that stop reporting: spans of equal samples that a motion cannot have made."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Array, Note, Signal

Mask = NDArray[np.bool_]
_REACH = 8  # samples over which the speed beside a span is taken
_USUAL = 0.99  # share of the samples outside whose changes are usual
_NEVER = 0.02  # share of equal neighbours up to which a sensor's noise is said to move every sample


@dataclass(frozen=True)
class Frozen:
    """A span of equal samples.

    Attributes:
        first: its first sample.
        last: its last sample.
        begin: s, of the first.
        end: s, of the last.
        jump: by how much the value jumps behind it, in the signal's unit; 0 at the log's end.
        unit: the signal's.
    """

    first: int
    last: int
    begin: float
    end: float
    jump: float
    unit: str

    def note(self, name: str) -> Note:
        """What the user reads."""
        count = self.last - self.first + 1
        jumped = f" and then jumps by {self.jump:.3g} {self.unit}" if self.jump else ""
        message = (
            f"Frozen: {name} repeats one value from {self.begin:.2f} to {self.end:.2f} s ({count} samples) amid "
            f"a motion{jumped}. The span is left out like a gap; check the sensor and its cable."
        )
        return Note("fault", name, message, count)


def find_frozen(signal: Signal, contract: DataContract) -> tuple[Frozen, ...]:
    """Spans of equal samples, at least `contract.frozen` s long, that a motion cannot have made.

    A motion ends in a standstill by braking: with the speed v before and the strongest braking a that the signal shows
    elsewhere it goes on for v² / 2a. A span is frozen if the value stops, or goes on behind it, from a speed whose
    braking distance is `contract.frozen_stop` usual changes of a sample; one such end suffices where the sensor's noise
    moves every other sample or half such a jump follows, and else both do, or a jump by `contract.frozen_jump` usual
    changes at its end. A machine that stands still when a log begins starts by itself: there only such a jump tells.

    Args:
        signal: a scalar channel; others have none.
        contract: thresholds.
    """
    if signal.value.ndim != 1 or len(signal) < 4 * _REACH:
        return ()
    runs = _runs(signal.value)
    longest = np.array([signal.time[last] - signal.time[first] for first, last in runs])
    suspected = [run for run, duration in zip(runs, longest, strict=True) if duration >= contract.frozen]
    if not suspected:
        return ()
    outside = np.ones(len(signal), bool)
    for first, last in suspected:
        outside[first : last + 1] = False
    changes = np.abs(np.diff(signal.value))[outside[1:] & outside[:-1]]
    if len(changes) < 4 * _REACH or not changes.any():
        return ()
    other = [signal.time[last] - signal.time[first] for first, last in runs if outside[first]]
    # A sensor slower than its topic repeats every value; so does one that creeps.
    suspected = [run for run in suspected if _span(signal, run) >= contract.frozen_rest * max(other, default=0.0)]
    usual = float(np.quantile(changes[changes > 0], _USUAL))
    noisy = float((changes == 0).mean()) <= _NEVER
    brake = _braking(signal, outside)
    found = [_frozen(signal, run, usual, brake, contract, noisy=noisy) for run in suspected]
    return tuple(span for span in found if span is not None)


def without(signal: Signal, spans: Sequence[Frozen], contract: DataContract) -> Signal:
    """The signal without frozen samples but the first of each span; the signal itself where too few would be left."""
    keep = np.ones(len(signal), bool)
    for span in spans:
        keep[span.first + 1 : span.last + 1] = False
    if keep.all() or keep.sum() < contract.minimum_samples:
        return signal
    return Signal(signal.name, signal.unit, signal.time[keep], signal.value[keep])


def _runs(value: Array) -> list[tuple[int, int]]:
    """First and last sample of every run of equal values with at least two."""
    edges = np.flatnonzero(np.diff(value) != 0.0)
    first, last = np.append(0, edges + 1), np.append(edges, len(value) - 1)
    return [(int(a), int(b)) for a, b in zip(first, last, strict=True) if b > a]


def _span(signal: Signal, run: tuple[int, int]) -> float:
    return float(signal.time[run[1]] - signal.time[run[0]])


def _speed(signal: Signal, first: int, last: int) -> float:
    """Mean speed from one sample to another."""
    return float((signal.value[last] - signal.value[first]) / (signal.time[last] - signal.time[first]))


def _braking(signal: Signal, outside: Mask) -> float:
    """Strongest usual change of speed outside of the suspected spans, in units per s²."""
    time, value = signal.time[::_REACH], signal.value[::_REACH]
    speed = np.diff(value) / np.diff(time)
    change = np.abs(np.diff(speed)) / (0.5 * (time[2:] - time[:-2]))
    inside = np.minimum(outside[::_REACH][:-2], np.minimum(outside[::_REACH][1:-1], outside[::_REACH][2:]))
    strongest = float(np.quantile(change[inside], _USUAL)) if inside.any() else np.inf
    return max(strongest, float(np.finfo(float).tiny))  # an even motion never brakes


def _frozen(
    signal: Signal, run: tuple[int, int], usual: float, brake: float, contract: DataContract, *, noisy: bool
) -> Frozen | None:
    first, last = run
    stops = goes = False
    jump = 0.0
    if first > _REACH:
        stops = _speed(signal, first - _REACH, first - 1) ** 2 / (2 * brake) > contract.frozen_stop * usual
    if last + 1 + _REACH < len(signal):
        goes = _speed(signal, last + 1, last + _REACH) ** 2 / (2 * brake) > contract.frozen_stop * usual
        jump = float(abs(signal.value[last + 1] - signal.value[last]))
    jumps = jump > contract.frozen_jump * usual
    leaps = jump > 0.5 * contract.frozen_jump * usual
    goes &= first > _REACH
    if not (jumps or (stops and goes) or ((noisy or leaps) and (stops or goes))):
        return None
    return Frozen(first, last, float(signal.time[first]), float(signal.time[last]), jump if jumps else 0.0, signal.unit)
