"""Tables as they lie on the disk: which format, which separator, and whether the last row is whole."""

import re
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from dr_lab.errors import DataError
from dr_lab.trajectory import Note

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}
_COMMA, _POINT = (re.compile(rf"(^|[;\t])\s*[-+]?\d*{mark}\d+", re.MULTILINE) for mark in (",", r"\."))
_LOOK = 65536  # bytes from either end of a file that are looked at before it is read


@dataclass(frozen=True)
class Rows:
    """Rows of a table.

    Attributes:
        table: the rows; column names carry no spaces around them.
        notes: what was found on reading them.
    """

    table: pa.Table
    notes: tuple[Note, ...]


def load(path: Path) -> Rows:
    """Read a whole table, CSV or, by its suffix, Parquet.

    The header tells what separates the columns of a CSV: commas, semicolons or tabs; beside the latter two numbers may
    have decimal commas. A last line that breaks off before its last column is left out.

    Raises:
        DataError: empty or unreadable file.
    """
    try:
        rows = Rows(pyarrow.parquet.read_table(path), ()) if path.suffix == ".parquet" else _csv(path)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        reason = str(error).splitlines()[0]
        raise DataError(f"Cannot read {path}: {reason}. Expected a header line and one row a sample.") from error
    if rows.table.num_rows == 0:
        raise DataError(f"{path} holds no rows. Record it again, or leave it out of logs.")
    return Rows(rows.table.rename_columns([name.strip() for name in rows.table.column_names]), rows.notes)


def _csv(path: Path) -> Rows:
    with path.open("rb") as file:
        header, _, body = file.read(_LOOK).decode("latin-1").partition("\n")
        file.seek(max(0, path.stat().st_size - _LOOK))
        unfinished = file.read().decode("utf-8", "replace").rpartition("\n")[2].strip()
    bare = re.sub(r'"[^"]*"', "", header)  # a name between quotes may hold any of them
    separator = max(_SEPARATORS, key=bare.count)
    decimal = "," if separator != "," and _COMMA.search(body) and not _POINT.search(body) else "."
    cut = 0

    def on_wrong_length(row: pyarrow.csv.InvalidRow) -> str:
        nonlocal cut
        if row.actual_columns > row.expected_columns or row.text.strip() != unfinished:
            return "error"
        cut += 1
        return "skip"

    table = pyarrow.csv.read_csv(
        path,
        parse_options=pyarrow.csv.ParseOptions(delimiter=separator, invalid_row_handler=on_wrong_length),
        convert_options=pyarrow.csv.ConvertOptions(strings_can_be_null=True, decimal_point=decimal),
    )
    notes = []
    if separator != ",":
        mark = " and numbers with decimal commas" if decimal == "," else ""
        notes.append(Note("separator", "", f"{path.name} is read as columns between {_SEPARATORS[separator]}{mark}."))
    if cut:
        message = f"{path.name} ends within a row (interrupted recording); {table.num_rows} complete rows were kept."
        notes.append(Note("cut", "", message, table.num_rows))
    return Rows(table, tuple(notes))
