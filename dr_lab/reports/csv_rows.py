"""Rows of a table as CSV, for spreadsheets and data frames."""

import csv
import io
from collections.abc import Mapping, Sequence


def rows_csv(rows: Sequence[Mapping[str, object]]) -> str:
    """One line a row below the names of the columns; what a row lacks is empty.

    Args:
        rows: values by column.
    """
    text, header = io.StringIO(), list(dict.fromkeys(name for row in rows for name in row))
    writer = csv.DictWriter(text, header, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
