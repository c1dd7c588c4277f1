"""Tables as they lie on the disk: which format, which separator, and whether the last row is whole."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
import pyarrow.parquet

from dr_lab.errors import DataError
from dr_lab.measurements.log_file import kind
from dr_lab.measurements.row_numbers import RowNumbers
from dr_lab.measurements.text_encoding import as_utf8
from dr_lab.trajectory import Note

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
# A number that may have a decimal comma, and one whose commas may be thousands separators instead.
_COMMA, _THOUSANDS = r"^\s*[-+]?(\d+|\d*,\d+|\d+,)([eE][-+]?\d+)?\s*$", r"^\s*[-+]?([1-9]\d{0,2}(,\d{3})+|\d+)\s*$"
_NUMBER = re.compile(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?")
_LINES = re.compile("\r\n|\r|\n")  # to Python other characters end a line, too
_LOOK = 65536  # bytes from either end of a file that are looked at before it is read


@dataclass(frozen=True)
class Rows:
    """Rows of a table.

    Attributes:
        table: the rows; column names carry no spaces around them.
        notes: what was found on reading them.
        numbers: where they stand in the file.
    """

    table: pa.Table
    notes: tuple[Note, ...]
    numbers: RowNumbers


def load(path: Path) -> Rows:
    """Read a whole table, CSV, compressed or not, or, by its suffix, Parquet.

    The header tells what separates the columns of a CSV: commas, semicolons or tabs. Its numbers have decimal points,
    or all of them decimal commas; numbers of the other kind, or with thousands separators, are left as text. Where
    commas may be either and other columns have points, they stay text too. A last line that breaks off before its last
    column is left out. Of encodings see `as_utf8`.

    Raises:
        DataError: empty or unreadable file.
    """
    try:
        text = kind(path) != ".parquet"
        table, notes = _csv(path) if text else (pyarrow.parquet.read_table(path), ())
        names = [name.strip() for name in table.column_names]
    except UnicodeError as error:
        raise DataError(f"Cannot read {path}: {error}. Expected a table; save it as UTF-8 text.") from error
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0]
        raise DataError(f"Cannot read {path}: {reason}. Expected a header line and one row a sample.") from error
    if table.num_rows == 0:
        raise DataError(f"{path} holds no rows. Record it again, or leave it out of logs.")
    return Rows(table.rename_columns(names), notes, RowNumbers.of(table.num_rows, text=text))


def missing_header(names: Sequence[str]) -> str:
    """What to do about names of columns that are all numbers, as messages say it; empty where one is none."""
    if not names or not all(_NUMBER.fullmatch(name) for name in names):
        return ""
    return (
        "the first line, which names the columns, seems to be missing, as it holds nothing but numbers; put a line of "
        "names before it, such as time,angle"
    )


def _csv(path: Path) -> tuple[pa.Table, tuple[Note, ...]]:
    """The table, and what was found on reading it."""
    content, encoding = as_utf8(pa.input_stream(path, compression="detect").read_buffer())
    header, first, *_ = [*_LINES.split(bytes(content[:_LOOK]).decode("utf-8", "replace")), "", ""]
    last = bytes(content[max(0, len(content) - _LOOK) :])
    unfinished = last.decode("utf-8", "replace").rpartition("\n")[2].strip()
    separator, decimal = _separator(header, first), "."
    table, cut = _parsed(content, separator, decimal, unfinished)
    if _has_decimal_commas(table, separator):
        decimal = ","
        table, cut = _parsed(content, separator, decimal, unfinished)
    notes = []
    if encoding:
        notes.append(Note("encoding", "", f"{path.name} is no UTF-8 text; its names are read as {encoding}."))
    if separator != "," or decimal == ",":
        mark = " and numbers with decimal commas" if decimal == "," else ""
        notes.append(Note("separator", "", f"{path.name} is read as columns between {_SEPARATORS[separator]}{mark}."))
    if cut:
        message = f"{path.name} ends within a row (interrupted recording); {table.num_rows} complete rows were kept."
        notes.append(Note("cut", "", message, table.num_rows))
    return table, tuple(notes)


def _separator(header: str, row: str) -> str:
    """The most frequent separator of the header, of those that are as frequent in a row if there are any."""
    bare = [re.sub(r'"[^"]*"', "", line) for line in (header, row)]  # what is between quotes may hold any of them

    def fits(mark: str) -> tuple[bool, int]:
        names, values = (line.count(mark) for line in bare)
        return 0 < names == values, names

    return max(_SEPARATORS, key=fits)


def _parsed(content: pa.Buffer, separator: str, decimal: str, unfinished: str) -> tuple[pa.Table, int]:
    """The complete rows, and how many were cut."""
    cut = 0

    def on_wrong_length(row: pyarrow.csv.InvalidRow) -> str:
        nonlocal cut
        if row.actual_columns > row.expected_columns or row.text.strip() != unfinished:
            return "error"
        cut += 1
        return "skip"

    table = pyarrow.csv.read_csv(
        pa.BufferReader(content),
        parse_options=pyarrow.csv.ParseOptions(delimiter=separator, invalid_row_handler=on_wrong_length),
        convert_options=pyarrow.csv.ConvertOptions(strings_can_be_null=True, decimal_point=decimal),
    )
    return table, cut


def _has_decimal_commas(table: pa.Table, separator: str) -> bool:
    """Whether a column that is text with decimal points is numbers with decimal commas.

    Commas before three digits each may separate thousands: they decide nothing where commas separate columns or
    another column has points.
    """
    texts = [column for column in table.columns if pa.types.is_string(column.type)]
    found = [column for column in texts if _all_match(column, _COMMA)]
    pointed = any(pa.types.is_floating(column.type) for column in table.columns)
    certain = any(not _all_match(column, _THOUSANDS) for column in found)
    return certain or (bool(found) and separator != "," and not pointed)


def _all_match(column: pa.ChunkedArray, pattern: str) -> bool:
    matches = pc.call_function("match_substring_regex", [column], pc.MatchSubstringOptions(pattern))
    return pc.call_function("all", [matches]).as_py()
