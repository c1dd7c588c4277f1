"""Logs that hold the same samples: copies, whole or in part, whatever their names and clocks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Log, Signal

_WORD = 32  # samples that are compared at a time
_DISTINCT = 8  # different values that such a word holds at least: a standstill looks the same in all logs
_MIX = np.random.default_rng(0).integers(1, 2**63, _WORD, np.uint64) | np.uint64(1)


@dataclass(frozen=True)
class Copy:
    """Samples of one log that another holds as well.

    Attributes:
        first: the one log's number.
        second: the other's, later in the list.
        signal: channel that is the same.
        begin: s, on the second log's clock.
        end: s.
        later: s by which they come later in the second log than in the first.
        samples: how many.
    """

    first: int
    second: int
    signal: str
    begin: float
    end: float
    later: float
    samples: int


def find_copies(logs: Sequence[Log], contract: DataContract) -> tuple[Copy, ...]:
    """Pairs of logs of which every moving output shares enough samples in a row at one shift (`contract`).

    Samples are compared in single precision, which survives a change of format; real machines never repeat 32 samples.

    Args:
        logs: all logs of a machine.
        contract: thresholds.
    """
    found = []
    words = [{name: _words(signal) for name, signal in log.outputs.items() if signal.value.ndim == 1} for log in logs]
    for second in range(len(logs)):
        for first in range(second):
            copy = _shared(logs, first, second, words[first], words[second], contract)
            if copy is not None:
                found.append(copy)
    return tuple(found)


def _words(signal: Signal) -> NDArray[np.uint64]:
    """A number for every 32 samples in a row, equal where they are; 0 where they hold too few different values."""
    value = np.ascontiguousarray(signal.value, np.float32) + np.float32(0.0)  # −0 is 0
    if len(value) < _WORD:
        return np.zeros(0, np.uint64)
    words = (sliding_window_view(value.view(np.uint32).astype(np.uint64), _WORD) * _MIX).sum(1, dtype=np.uint64)
    changes = np.concatenate([[0], np.cumsum(np.diff(value) != 0.0)])
    lively = changes[_WORD - 1 :] - changes[: len(value) - _WORD + 1] >= _DISTINCT
    return np.where(lively, words, np.uint64(0))


def _shared(
    logs: Sequence[Log],
    first: int,
    second: int,
    one: dict[str, NDArray[np.uint64]],
    other: dict[str, NDArray[np.uint64]],
    contract: DataContract,
) -> Copy | None:
    """The longest copy; every output that both logs move must have one."""
    best = None
    for name, here in one.items():
        there = other[name]
        if not (here.any() and there.any()):
            continue
        run = _longest(here, there)
        if run is None or run[2] < contract.copied:
            return None
        start, match, count = run
        time, before = logs[second].outputs[name].time, logs[first].outputs[name].time
        begin, end = float(time[match]), float(time[match + count - 1])
        if end - begin < contract.copied_for:
            return None
        if best is None or count > best.samples:
            best = Copy(first, second, name, begin, end, begin - float(before[start]), count)
    return best


def _longest(here: NDArray[np.uint64], there: NDArray[np.uint64]) -> tuple[int, int, int] | None:
    """Start in the one, start in the other and length of the longest run of equal samples."""
    _, at, match = np.intersect1d(here, there, return_indices=True)
    keep = here[at] != 0
    at, match = at[keep], match[keep]
    if not len(at):
        return None
    shift = match - at
    lags, counts = np.unique(shift, return_counts=True)
    lag = int(lags[counts.argmax()])
    start, stop = max(0, -lag), min(len(here), len(there) - lag)
    same = here[start:stop] == there[start + lag : stop + lag]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    begins, ends = edges[::2], edges[1::2]
    longest = int((ends - begins).argmax())
    return (
        start + int(begins[longest]),
        start + int(begins[longest]) + lag,
        int(ends[longest] - begins[longest]) + _WORD - 1,
    )
