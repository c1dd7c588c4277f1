"""Columns of numbers in which some cells are text, so that tables take the whole column for text."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa

from dr_lab.measurements.table_file import Rows, load

# A number with a decimal point, and one with a decimal comma.
_NUMBERS = tuple(re.compile(rf"[-+]?(\d+{mark}?\d*|{mark}\d+)([eE][-+]?\d+)?|[-+]?inf") for mark in (r"\.", ","))
_SHOWN = 20  # letters of a cell


@dataclass(frozen=True)
class TextColumn:
    """A column of numbers that some text spoils.

    Attributes:
        file: name.
        column: its name.
        cells: how many cells are no numbers.
        rows: of the table.
        place: of the first of them: line of a text file, empty lines not counted, or row of another.
        text: of that cell.
    """

    file: str
    column: str
    cells: int
    rows: int
    place: str
    text: str

    def __str__(self) -> str:
        """As messages say it."""
        count = f"{self.cells} of its {self.rows} cells {'is no number' if self.cells == 1 else 'are no numbers'}"
        first = "" if self.cells == 1 else "the first of them "
        return (
            f"{self.file}: column {self.column} is read in no log, as {count}: {first}{self.text!r} in {self.place}. "
            "Write the number there, or leave such a cell empty."
        )


def text_columns(path: Path, most: float) -> tuple[TextColumn, ...]:
    """The columns of a table that are text, but mostly hold numbers.

    Args:
        path: a table.
        most: share of a column's cells, empty ones apart, that may be text.

    Raises:
        DataError: the file cannot be read.
    """
    rows = load(path)
    named = zip(rows.table.column_names, rows.table.columns, strict=True)
    texts = [(name, column) for name, column in named if pa.types.is_string(column.type)]
    found = (_spoilt(path, rows, name, column.to_pylist(), most) for name, column in texts)
    return tuple(each for each in found if each is not None)


def _spoilt(path: Path, rows: Rows, name: str, cells: Sequence[str | None], most: float) -> TextColumn | None:
    """What spoils a column; None of one that is of text."""
    filled = [(row, cell.strip()) for row, cell in enumerate(cells) if cell and cell.strip()]
    wrong = min(([each for each in filled if not number.fullmatch(each[1])] for number in _NUMBERS), key=len)
    if not wrong or len(wrong) > most * len(filled):
        return None
    row, text = wrong[0]
    place = rows.numbers.kept(np.arange(len(cells)) == row)
    return TextColumn(path.name, name, len(wrong), len(cells), str(place), text[:_SHOWN])
