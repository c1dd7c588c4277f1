"""The column of a table that is its clock, in which unit, and the column that tells several logs in one file apart."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from dr_lab.errors import DataError
from dr_lab.measurements.inventory import by_name
from dr_lab.measurements.raw_log import TimeAxis
from dr_lab.measurements.table_file import load, missing_header
from dr_lab.proposal.split_clock import split_clocks
from dr_lab.proposal.tokens import tokens

_CLOCK_WORDS = (
    *("t", "time", "timestamp", "stamp", "clock", "sec", "seconds", "secs", "ts", "elapsed"),
    *("zeit", "temps", "tiempo", "tempo"),
)
_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_SAID = {"ms": "ms", "msec": "ms", "millis": "ms", "us": "us", "usec": "us", "micros": "us", "ns": "ns", "nsec": "ns"}
_RISES = 0.98  # share of the rows whose clock is later than that of the row before
_PERIODS = (2e-4, 0.2)  # s, between two rows of a machine's log: 5 kHz and 5 Hz
_TYPICAL = 3e-3  # s, as in dr_lab.measurements.sampling


@dataclass(frozen=True)
class Clock:
    """How a table tells the time.

    Attributes:
        axis: column and unit.
        group: column whose values tell logs apart, or None where a file is one log.
        doubt: why the unit is not sure, empty where it is.
    """

    axis: TimeAxis
    group: str | None
    doubt: str


def find_clock(path: Path) -> Clock:
    """Find the clock of a table: a column that rises from row to row, by name and by how fast it rises.

    Args:
        path: a table.

    Raises:
        DataError: no column alone is a clock, or none has a name; the message says what to add.
    """
    table = load(path).table
    columns = by_name(table)
    rising = {name: values for name, column in columns.items() if (values := _rising(column)) is not None}
    split = [*split_clocks(columns)]
    rests = {each.rest for each in split}
    named = [name for name in rising if {*tokens(name)} & {*_CLOCK_WORDS, *_SAID} and name not in rests]
    if bare := missing_header(table.column_names):
        raise DataError(f"{path.name}: {bare}. The line is {', '.join(table.column_names)}.")
    if split and not named:
        raise DataError(f"{path.name} has no clock: {split[0]}")
    if not named and (coarse := _coarse(columns)):
        raise DataError(
            f"{path.name} has no clock: {coarse} rises, but keeps its value over {_longest(columns[coarse])} rows. "
            "Write the time of each row in s, such as the number of the row times the sampling period."
        )
    if not named:
        other = f" Columns that rise, but are not called time: {', '.join(rising)}." if rising else ""
        raise DataError(
            f"{path.name} has no clock: no column that is called time, t or timestamp rises from row to row.{other} "
            f"Add a column time in s, or rename the one that is it. Columns: {', '.join(table.column_names)}."
        )
    name = min(named, key=lambda each: (_rank(each), table.column_names.index(each)))
    unit, doubt = _unit(name, columns[name].type, rising[name])
    return Clock(TimeAxis(column=name, unit=unit), _group(table, rising[name]), doubt)


def _rank(name: str) -> int:
    """Plain names of a clock before others that hold such a word."""
    return 0 if {*tokens(name)} <= {*_CLOCK_WORDS, *_SAID} else 1


def _coarse(columns: Mapping[str, pa.ChunkedArray]) -> str | None:
    """A column that is called a clock and hardly falls, but counts whole seconds or the like; None without one."""
    for name, column in columns.items():
        values = _numbers(column) if {*tokens(name)} & {*_CLOCK_WORDS, *_SAID} else None
        if values is not None and len(values) > 2 and (np.diff(values) >= 0).mean() > _RISES and np.ptp(values) > 0:
            return name
    return None


def _longest(column: pa.ChunkedArray) -> int:
    """Most rows in a row over which a column keeps its value."""
    values = _numbers(column)
    if values is None:
        return 0
    ends = np.concatenate([[-1], np.flatnonzero(np.diff(values) != 0), [len(values) - 1]])
    return int(np.diff(ends).max())


def _rising(column: pa.ChunkedArray) -> np.ndarray | None:
    """A column's numbers where they rise, in ns where they are times of day; None where they do not."""
    values = _numbers(column)
    return values if values is not None and len(values) > 2 and (np.diff(values) > 0).mean() > _RISES else None


def _numbers(column: pa.ChunkedArray) -> np.ndarray | None:
    """A column's finite numbers, in ns where they are times of day; None of text."""
    kind = column.type
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        scale = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0}[kind.unit]
        values = column.cast(pa.int64()).fill_null(0).to_numpy().astype(np.float64) * scale
    elif pa.types.is_floating(kind) or pa.types.is_integer(kind):
        if pa.types.is_integer(kind) and column.null_count < len(column):
            first = column.drop_null()[0]
            values = (column.fill_null(first).to_numpy() - first.as_py()).astype(np.float64)
        else:
            values = column.cast(pa.float64()).to_numpy()
    else:
        return None
    return values[np.isfinite(values)]


def _unit(name: str, kind: pa.DataType, values: np.ndarray) -> tuple[str, str]:
    """Unit of a clock: that of its type, its name, or in which its period is one of machines."""
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        return "s", ""
    steps = np.diff(values)
    period = float(np.median(steps[steps > 0]))
    usual = min(_UNITS, key=lambda unit: abs(np.log(period * _UNITS[unit] / _TYPICAL)))
    words = tokens(name)
    said = next((_SAID[word] for word in words if word in _SAID), "s" if words[-1] in ("s", "sec", "seconds") else "")
    low, high = _PERIODS
    if said and low <= period * _UNITS[said] <= high:
        return said, ""
    plain = "s" if low <= period <= high else usual
    if said and said != plain:
        rate = 1 / (period * _UNITS[plain])
        return plain, f"its name says {said}, but its rows are {period:.3g} apart: read as {plain}, {rate:.3g} Hz"
    doubt = f"rows are {period:.3g} apart, {1 / (period * _UNITS[plain]):.3g} Hz if they are {plain}"
    return plain, "" if plain == "s" else doubt


def _group(table: pa.Table, clock: np.ndarray) -> str | None:
    """A column that changes just where the clock is set back."""
    if len(clock) != table.num_rows:
        return None
    back = np.flatnonzero(np.diff(clock) <= 0)
    for name, column in by_name(table).items() if len(back) else ():
        if pa.types.is_integer(column.type) or pa.types.is_string(column.type):
            codes = column.combine_chunks().dictionary_encode().indices.to_numpy(zero_copy_only=False)
            if np.array_equal(np.flatnonzero(np.diff(codes) != 0), back) and len(set(codes)) == len(back) + 1:
                return name
    return None
