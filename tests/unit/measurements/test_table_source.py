"""CSV and Parquet logs."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.signal_map import channel_map
from dr_lab.measurements.table import TableSource

TEXT = "time_ms, q1,q2,flag,name\n10,0.5,1,true,a\n20,,2,false,b\n30,1.5,nan,true,c\n"


@pytest.fixture
def csv(tmp_path: Path) -> Path:
    path = tmp_path / "log.csv"
    path.write_text(TEXT)
    return path


def column(path: Path, place: object, time_column: str = "time_ms", unit: str = "ms") -> np.ndarray:
    return (
        TableSource(path, time_column, unit).samples(channel_map("sensor.x", {"column": place, "unit": "1"}, "")).value
    )


def test_columns_combinations_vectors_and_missing_cells(csv: Path) -> None:
    np.testing.assert_array_equal(column(csv, "q1"), [0.5, np.nan, 1.5])
    np.testing.assert_array_equal(column(csv, "q2"), [1, 2, np.nan])
    np.testing.assert_array_equal(column(csv, "flag"), [1, 0, 1])
    np.testing.assert_array_equal(column(csv, {"q2": 1, "q1": -2}), [0.0, np.nan, np.nan])
    np.testing.assert_array_equal(column(csv, ["q1", "q2"])[0], [0.5, 1.0])


def test_times_count_from_the_first_row_in_seconds(csv: Path) -> None:
    samples = TableSource(csv, "time_ms", "ms").samples(channel_map("q", {"column": "q1", "unit": "rad"}, ""))
    np.testing.assert_allclose(samples.stamps["column"].elapsed, [0.0, 0.01, 0.02], atol=1e-15)


def test_parquet_and_timestamps_keep_nanoseconds(tmp_path: Path) -> None:
    stamps = 1_700_000_000_000_000_000 + np.array([0, 1, 1_000_000_003])
    table = pa.table({"t": pa.array(stamps, pa.timestamp("ns")), "i": stamps, "q": [1.0, 2.0, 3.0]})
    pyarrow.parquet.write_table(table, tmp_path / "log.parquet")
    for name, unit in (("t", "s"), ("i", "ns")):
        source = TableSource(tmp_path / "log.parquet", name, unit)
        samples = source.samples(channel_map("q", {"column": "q", "unit": "rad"}, ""))
        np.testing.assert_allclose(samples.stamps["column"].elapsed, [0.0, 1e-9, 1.000000003], rtol=1e-15)
        np.testing.assert_array_equal(samples.value, [1, 2, 3])


def test_missing_column_lists_those_there_are(csv: Path) -> None:
    with pytest.raises(
        UnknownNameError, match=r"no column 'q11' in log\.csv\. Did you mean 'q1'\? Available: flag, name"
    ):
        column(csv, "q11")
    with pytest.raises(UnknownNameError, match=r"no column 'time' in log\.csv"):
        column(csv, "q1", "time", "s")


def test_text_is_no_number(csv: Path) -> None:
    with pytest.raises(DataError, match=r"column 'name' holds string \(e\.g\. 'a'\), not numbers"):
        column(csv, "name")


def test_a_topic_entry_is_refused(csv: Path) -> None:
    entry = {"topic": "/q", "field": "data", "unit": "rad"}
    with pytest.raises(DataError, match=r"is a table\. Write column: NAME"):
        TableSource(csv, "time_ms", "ms").samples(channel_map("q", entry, ""))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "Cannot read"),
        ("t,q\n", "holds no rows"),
        ("t,q\n0,1\n1\n", "Cannot read"),
        ("t,q\n,1\n,2\n", "holds no time"),
        ("t,q,q\n0,1,2\n1,1,2\n", "has 2 columns 'q'"),
    ],
)
def test_broken_tables(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(DataError, match=message):
        column(tmp_path / "a.csv", "q", "t", "s")


def test_a_broken_parquet(tmp_path: Path) -> None:
    (tmp_path / "a.parquet").write_bytes(b"PAR1 not really")
    with pytest.raises(DataError, match="Cannot read"):
        column(tmp_path / "a.parquet", "q", "t", "s")
