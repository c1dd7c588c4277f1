"""Cells of a table that hold no number: told as such, with their lines."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from csv_logs import ANGLE, TIME, Q

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import TimeAxis, read_log
from dr_lab.measurements.read import read

NONE = "of 2000 cells are empty or no finite numbers"


def emptied(path: Path, lines: dict[int, str]) -> Path:
    """A table of time and angle, some lines of which are others; the first line names the columns."""
    rows = ["time,q", *(f"{t:.9g},{q:.9g}" for t, q in zip(TIME, ANGLE, strict=True))]
    for line, text in lines.items():
        rows[line - 1] = text
    path.write_text("\n".join(rows) + "\n")
    return path


def test_empty_cells_are_told_with_their_lines(tmp_path: Path, contract: DataContract) -> None:
    lines = {line: f"{TIME[line - 2]:.9g},{cell}" for line, cell in ((5, ""), (9, "nan"), (7, ""), (1001, "inf"))}
    (note,) = read_log(emptied(tmp_path / "a.csv", lines), Q, {}, contract).notes
    assert (note.kind, note.count) == ("nan", 4)
    assert note.message == f"q.position: 4 {NONE} (lines 5, 7, 9 and 1 more); they were dropped."


def test_lines_are_those_of_the_file_where_a_part_of_it_is_read(tmp_path: Path, contract: DataContract) -> None:
    path = emptied(tmp_path / "a.csv", {100: f"{TIME[98]:.9g},", 1500: f"{TIME[1498]:.9g},"})
    (note,) = read_log(path, Q, {}, contract, time=TimeAxis(start=1.0)).notes
    assert "(line 1500); they were dropped" in note.message


def test_lines_are_those_of_the_file_in_each_group(tmp_path: Path, contract: DataContract) -> None:
    rows = [
        f"{t:.9g},{'' if k == 70 else f'{q:.9g}'},{k % 2}" for k, (t, q) in enumerate(zip(TIME, ANGLE, strict=True))
    ]
    path = tmp_path / "a.csv"
    path.write_text("time,q,g\n" + "\n".join(rows) + "\n")
    even, odd = read("bench", [str(path)], Q, contract, group="g").fit
    assert ["1 of 1000 cells are empty" in note.message and "(line 72)" in note.message for note in even.notes] == [
        True
    ]
    assert odd.notes == ()


def test_an_empty_time_is_told_as_one(tmp_path: Path, contract: DataContract) -> None:
    (note,) = read_log(emptied(tmp_path / "a.csv", {3: ",0.5"}), Q, {}, contract).notes
    told = "1 of 2000 cells, or those of their times, are empty or no finite numbers (line 3)"
    assert told in note.message


def test_other_tables_have_rows(tmp_path: Path, contract: DataContract) -> None:
    angle = [None if k == 4 else float(q) for k, q in enumerate(ANGLE)]
    pyarrow.parquet.write_table(pa.table({"time": TIME, "q": angle}), tmp_path / "a.parquet")
    (note,) = read_log(tmp_path / "a.parquet", Q, {}, contract).notes
    assert f"1 {NONE} (row 5)" in note.message


def test_a_column_without_numbers_is_refused(tmp_path: Path, contract: DataContract) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time,q\n" + "\n".join(f"{t}," for t in np.arange(30)) + "\n")
    with pytest.raises(
        DataError, match=r"'q\.position': all 30 cells are empty or no finite numbers\. Check its column"
    ):
        read_log(path, Q, {}, contract)
