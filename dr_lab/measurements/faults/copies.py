"""Logs that hold the same samples: copies, whole or in part, whatever their names and clocks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from dr_lab.measurements.contract import DataContract
from dr_lab.trajectory import Array, Log

_WORD = 32  # samples that are compared at a time
_TURN = 2**24  # parts of a turn that are told apart; as many as in single precision
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


class _Words(NamedTuple):
    """Every 32 samples in a row of a channel.

    Attributes:
        word: a number that is the same where they are, shape (n,).
        lively: whether they hold enough different values, shape (n,).
    """

    word: NDArray[np.uint64]
    lively: NDArray[np.bool_]


def find_copies(logs: Sequence[Log], contract: DataContract, wraps: Mapping[str, float]) -> tuple[Copy, ...]:
    """Pairs of logs of which every moving output shares enough samples in a row at one shift (`contract`).

    Samples are compared in single precision, which survives a change of format; real machines never repeat 32 samples
    in motion. A standstill may lie within a copy, and shows none.

    Args:
        logs: all logs of a machine.
        contract: thresholds.
        wraps: by how much outputs jump in their files, by name; each log has counted its turns from where it begins.
    """
    found = []
    kinds = [[_words_of(log, turns) for log in logs] for turns in ([{}, wraps] if wraps else [{}])]
    for second in range(len(logs)):
        for first in range(second):
            shared = (_shared(logs, first, second, words[first], words[second], contract) for words in kinds)
            copy = next((each for each in shared if each is not None), None)
            if copy is not None:
                found.append(copy)
    return tuple(found)


def _words_of(log: Log, wraps: Mapping[str, float]) -> dict[str, _Words]:
    """Words of the scalar outputs, of those that wrap without their turns."""
    scalars = {name: signal.value for name, signal in log.outputs.items() if signal.value.ndim == 1}
    return {name: _words(value, wraps.get(name, 0.0)) for name, value in scalars.items()}


def _words(value: Array, wrap: float) -> _Words:
    shown = np.mod(np.rint(value / wrap * _TURN), _TURN) if wrap else value
    single = np.ascontiguousarray(shown, np.float32) + np.float32(0.0)  # −0 is 0
    if len(single) < _WORD:
        return _Words(np.zeros(0, np.uint64), np.zeros(0, bool))
    words = (sliding_window_view(single.view(np.uint32).astype(np.uint64), _WORD) * _MIX).sum(1, dtype=np.uint64)
    changes = np.concatenate([[0], np.cumsum(np.diff(single) != 0.0)])
    return _Words(words, changes[_WORD - 1 :] - changes[: len(single) - _WORD + 1] >= _DISTINCT)


def _shared(
    logs: Sequence[Log],
    first: int,
    second: int,
    one: dict[str, _Words],
    other: dict[str, _Words],
    contract: DataContract,
) -> Copy | None:
    """The longest copy; every output that both logs move must have one."""
    best = None
    for name, here in one.items():
        there = other[name]
        if not (here.lively.any() and there.lively.any()):
            continue
        run = _longest(here, there)
        if run is None or run.moving < contract.copied:
            return None
        time, before = logs[second].outputs[name].time, logs[first].outputs[name].time
        begin, end = float(time[run.match]), float(time[run.match + run.samples - 1])
        if (end - begin) * run.moving / run.samples < contract.copied_for:
            return None
        if best is None or run.samples > best.samples:
            best = Copy(first, second, name, begin, end, begin - float(before[run.start]), run.samples)
    return best


class _Run(NamedTuple):
    """Equal samples in a row.

    Attributes:
        start: where they begin in the one log.
        match: where in the other.
        samples: how many.
        moving: how many of them are in motion.
    """

    start: int
    match: int
    samples: int
    moving: int


def _longest(here: _Words, there: _Words) -> _Run | None:
    """The run of equal samples with most motion at the shift that most words in motion share."""
    places, others = np.flatnonzero(here.lively), np.flatnonzero(there.lively)
    _, at, match = np.intersect1d(here.word[places], there.word[others], return_indices=True)
    if not len(at):
        return None
    lags, counts = np.unique(others[match] - places[at], return_counts=True)
    lag = int(lags[counts.argmax()])
    start, stop = max(0, -lag), min(len(here.word), len(there.word) - lag)
    same = here.word[start:stop] == there.word[start + lag : stop + lag]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    begins, ends = edges[::2], edges[1::2]
    moved = np.concatenate([[0], np.cumsum(here.lively[start:stop])])
    moving = moved[ends] - moved[begins]
    most = int(moving.argmax())
    begin, count = start + int(begins[most]), int(ends[most] - begins[most]) + _WORD - 1
    return _Run(begin, begin + lag, count, min(int(moving[most]) + _WORD - 1, count))
