"""Cells of text in columns of numbers: init says which column they keep from being read."""

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main
from dr_lab.measurements.text_columns import text_columns


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


def spoilt(path: Path, column: int, lines: dict[int, str]) -> str:
    """Write text into a column, by lines of the file; gives the file's name."""
    rows = [line.split(",") for line in path.read_text().splitlines()]
    for line, text in lines.items():
        rows[line - 1][column] = text
    path.write_text("\n".join(",".join(row) for row in rows) + "\n")
    return path.name


def test_a_column_that_text_keeps_from_being_read_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    logs = plain_logs(Path("logs"))
    spoilt(logs[1], 2, {31: "3.May", 40: "n.n.", 41: ""})
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    told = "log_1.csv: column shoulder_torque is read in no log, as 2 of its 1200 cells are no numbers: the first of "
    assert f"{told}them '3.May' in line 31." in capsys.readouterr().out
    page = " ".join(line.lstrip("# ") for line in Path("mine/measurements/two.yaml").read_text().splitlines())
    assert told in page


@pytest.mark.parametrize(("column", "refused"), [(1, "holds no numbers beside its clock"), (0, "has no clock")])
def test_a_refusal_says_what_text_keeps_from_being_read(
    column: int, refused: str, capsys: pytest.CaptureFixture[str]
) -> None:
    log = Path("log.csv")
    log.write_text("time,q\n" + "\n".join(f"{0.01 * k:.2f},{k % 7}" for k in range(100)) + "\n")
    spoilt(log, column, {12: "0.1O"})
    Path("two.xml").write_text(
        '<mujoco><worldbody><body><joint name="turn"/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    assert main(["init", "two.xml", "log.csv"]) == 2
    told = capsys.readouterr().err
    assert refused in told
    assert (
        f"column {'time' if column == 0 else 'q'} is read in no log, as 1 of its 100 cells is no number: '0.1O'" in told
    )


def test_text_of_other_kinds_is_none_of_numbers() -> None:
    """Names are text throughout; decimal commas, thousands and empty cells are numbers to whoever wrote them."""
    table = pa.table(
        {"name": ["a", "b", "7", None], "x": ["1,5", "-2,25", "3e4", "oops"], "n": ["1", "", "2.5", "inf"]}
    )
    pyarrow.parquet.write_table(table, "a.parquet")
    (found,) = text_columns(Path("a.parquet"), 0.5)
    assert (found.column, found.cells, found.rows, found.place, found.text) == ("x", 1, 4, "row 4", "oops")


@pytest.mark.parametrize(("first", "step", "read"), [(0, 1, True), (1000, 10, True), (0.0, 0.5, False)])
def test_a_count_of_the_rows_is_no_reading(
    first: float, step: float, capsys: pytest.CaptureFixture[str], *, read: bool
) -> None:
    logs = plain_logs(Path("logs"))
    for log in logs:
        header, *rows = log.read_text().splitlines()
        counted = [f"{first + step * k},{row}" for k, row in enumerate(rows)]
        log.write_text("\n".join([f"sample,{header}", *counted]) + "\n")
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    told = capsys.readouterr().out
    assert ("sample (counts the rows)" in told) == read
