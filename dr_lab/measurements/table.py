"""CSV and Parquet logs: one row a sample, one column a quantity, one column the time."""

import re
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.samples import Samples, Stamps, combine
from dr_lab.measurements.signal_map import ChannelMap
from dr_lab.measurements.table_file import Rows, load, missing_header
from dr_lab.measurements.units import Unit, unit
from dr_lab.trajectory import Array, Note

_NUMERIC = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, pa.types.is_decimal)
_LISTS = (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list)
_ENTRY = re.compile(r"(?P<column>.+)\[(?P<index>\d+)\]")
_NUMBER = re.compile(r"\s*[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?\s*")


class TableSource:
    """A CSV or Parquet file.

    Times count from the first row that has one.

    Args:
        path: the file; the suffix tells which format it has.
        time_column: column with the rows' times.
        time_unit: unit of that column; a column of timestamps or durations needs none.
        time_scale: factor into that unit, e.g. the period where the column counts samples.
        rows: those that count, from `grouped`; None takes the whole file.

    Raises:
        DataError: empty or unreadable file, a time column without a time, or one whose unit is none of time.
        UnknownNameError: no such column; the message lists them.
    """

    natural_clock = "column"

    def __init__(
        self, path: Path, time_column: str, time_unit: str, time_scale: float = 1.0, rows: Rows | None = None
    ) -> None:
        self._path = path
        self._rows = load(path) if rows is None else rows
        self._columns: dict[str, Array] = {}
        self._stamps = Stamps(time_scale * self._elapsed(time_column, time_unit), zero=0.0)

    @property
    def notes(self) -> tuple[Note, ...]:
        """How the file was read, and whether its last row was cut."""
        return self._rows.notes

    def samples(self, channel: ChannelMap) -> Samples:
        """Read one channel.

        Raises:
            UnknownNameError: no such column.
            DataError: a column that holds no numbers, or a channel that names a topic.
        """
        if channel.topic:
            raise DataError(
                f"Channel {channel.name!r} names topic {channel.topic!r}, but {self._path.name} is a table. "
                "Write column: NAME instead of topic and field."
            )
        return Samples(combine(channel, self._column), {"column": self._stamps}, "table", 0, self._rows.numbers)

    def _elapsed(self, name: str, time_unit: str) -> Array:
        column = self._raw(name)
        if pa.types.is_timestamp(column.type) or pa.types.is_duration(column.type):
            time_unit = column.type.unit
            column = column.cast(pa.int64())
        if pa.types.is_integer(column.type) and column.null_count < len(column):
            # Subtract first, in integers: nanoseconds since 1970 have more digits than a float64.
            first = column.drop_null()[0]
            whole = column.fill_null(first).cast(pa.int64(), safe=False).to_numpy()  # unsigned ones would wrap around
            elapsed = (whole - whole[column.is_valid().to_numpy().argmax()]).astype(np.float64)
            elapsed[column.is_null().to_numpy()] = np.nan
        else:
            time = _numbers(column, name, self._path)
            known = time[np.isfinite(time)]
            if len(known) == 0:
                raise DataError(f"{self._path}: column {name!r} holds no time.")
            elapsed = time - known[0]
        return elapsed * _time_unit(time_unit).factor

    def _column(self, name: str) -> Array:
        if name not in self._columns:
            self._columns[name] = _numbers(self._raw(name), name, self._path)
        return self._columns[name]

    def _raw(self, name: str) -> pa.ChunkedArray:
        return _column(self._rows.table, name, self._path)


def grouped(path: Path, column: str) -> dict[str, Rows]:
    """Rows of a table by the value of a column, in the order in which the values first appear.

    Rows without a value belong to no group.

    Raises:
        DataError: empty or unreadable file, or a column without a value.
        UnknownNameError: no such column; the message lists them.
    """
    rows = load(path)
    values = _column(rows.table, column, path).combine_chunks()
    if values.null_count == len(values):
        raise DataError(f"{path}: column {column!r} holds no value, so it tells no logs apart. Correct group.")
    coded = values.dictionary_encode()
    places = coded.indices.to_numpy(zero_copy_only=False)
    kept = [places == k for k in range(len(coded.dictionary))]
    return {
        _text(value): Rows(rows.table.filter(pa.array(keep)), rows.notes, rows.numbers.kept(keep))
        for value, keep in zip(coded.dictionary, kept, strict=True)
    }


def _time_unit(given: object) -> Unit:
    text = str(given)
    found = unit(text)
    if found.dimension != "[time]" and (found.dimension, found.factor) != ("dimensionless", 1.0):
        raise DataError(
            f"time.unit is {text!r} of dimension {found.dimension}; expected s, ms, us, ns, min or h, or 1 for one "
            "that counts samples, with the seconds of a sample in time.scale."
        )
    return found


def _text(value: pa.Scalar) -> str:
    plain = value.as_py()
    return str(int(plain)) if isinstance(plain, float) and plain.is_integer() else str(plain)


def is_list(kind: pa.DataType) -> bool:
    """Whether a column holds lists, of which ``column[0]`` is the first entry."""
    return any(is_kind(kind) for is_kind in _LISTS)


def _column(table: pa.Table, name: str, path: Path) -> pa.ChunkedArray:
    if name not in table.column_names:
        entry = _ENTRY.fullmatch(name)
        if entry and entry["column"] in table.column_names:
            return _entry(_column(table, entry["column"], path), entry["column"], int(entry["index"]), path)
        alone = " (one column: neither commas nor semicolons nor tabs in its header)" if table.num_columns == 1 else ""
        bare = missing_header(table.column_names)
        raise UnknownNameError("column", name, table.column_names, f"{path.name}{f' ({bare})' if bare else alone}")
    if (count := table.column_names.count(name)) > 1:
        raise DataError(f"{path} has {count} columns {name!r}. Give each column a name of its own.")
    return table.column(name)


def _entry(column: pa.ChunkedArray, name: str, index: int, path: Path) -> pa.ChunkedArray:
    """One entry of every list of a column; empty where a list is empty or missing."""
    if not is_list(column.type):
        raise DataError(
            f"{path.name}: column {name!r} holds {column.type}, no lists; write its name without [{index}]."
        )
    lengths = pc.call_function("list_value_length", [column])
    longest = pc.call_function("max", [lengths]).as_py() or 0
    if index >= longest:
        raise DataError(
            f"{path.name}: the lists of column {name!r} have up to {longest} entries; there is no [{index}]."
        )
    held = pc.call_function("greater", [lengths, pa.scalar(index, lengths.type)])
    known = pc.call_function("if_else", [held, column, pa.scalar(None, column.type)])
    return pc.call_function("list_element", [known, pa.scalar(index)])


def _numbers(column: pa.ChunkedArray, name: str, path: Path) -> Array:
    kind = column.type
    if pa.types.is_null(kind):
        return np.full(len(column), np.nan)
    if not any(is_kind(kind) for is_kind in _NUMERIC):
        if is_list(kind):
            raise DataError(f"{path.name}: column {name!r} holds lists. Take one entry of each, e.g. {name}[0].")
        example = f" (e.g. {_no_number(column)!r})" if pa.types.is_string(kind) else ""
        raise DataError(
            f"{path.name}: column {name!r} holds {kind}{example}, not numbers. Write numbers without thousands "
            "separators, with the same decimal mark in all columns, and nothing where there is none; or name another "
            "column."
        )
    column = column.cast(pa.float64(), safe=False)  # of whole numbers beyond 2^53 the last digits are rounded
    return column.to_numpy(zero_copy_only=False).astype(np.float64)


def _no_number(column: pa.ChunkedArray) -> object:
    """The first value that is no number, with either decimal mark, or else the first."""
    values = [value for value in column.to_pylist() if value is not None]
    return next((value for value in values if not _NUMBER.fullmatch(str(value))), values[0] if values else None)
