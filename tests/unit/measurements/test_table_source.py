"""CSV and Parquet logs."""

import bz2
import gzip
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements import log_file, text_encoding
from dr_lab.measurements.signal_map import channel_map
from dr_lab.measurements.table import TableSource
from dr_lab.measurements.table_file import load

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


def test_whole_numbers_beyond_2_to_53_and_decimals_are_numbers(tmp_path: Path) -> None:
    table = pa.table({"t": [0.0, 1.0], "i": [2**60 + 1, 7], "d": [Decimal("1.25"), None]})
    pyarrow.parquet.write_table(table, tmp_path / "a.parquet")
    np.testing.assert_array_equal(column(tmp_path / "a.parquet", "i", "t", "s"), [2.0**60, 7.0])
    np.testing.assert_array_equal(column(tmp_path / "a.parquet", "d", "t", "s"), [1.25, np.nan])


def test_durations_are_times_and_no_channels(tmp_path: Path) -> None:
    lasted = pa.array([5_000_000_001, 7_000_000_002], pa.duration("ns"))
    stamps = pa.array([1_700_000_000_000_000_001] * 2, pa.timestamp("ns"))
    pyarrow.parquet.write_table(pa.table({"t": lasted, "s": stamps, "q": [1.0, 2.0]}), tmp_path / "a.parquet")
    samples = TableSource(tmp_path / "a.parquet", "t", "s").samples(
        channel_map("q", {"column": "q", "unit": "rad"}, "")
    )
    np.testing.assert_allclose(samples.stamps["column"].elapsed, [0.0, 2.000000001], rtol=1e-15)
    for name, kind in {"t": "duration", "s": "timestamp"}.items():
        with pytest.raises(DataError, match=rf"column '{name}' holds {kind}\[ns\], not numbers"):
            column(tmp_path / "a.parquet", name, "t", "s")


def test_missing_column_lists_those_there_are(csv: Path) -> None:
    with pytest.raises(
        UnknownNameError, match=r"no column 'q11' in log\.csv\. Did you mean 'q1'\? Available: flag, name"
    ):
        column(csv, "q11")
    with pytest.raises(UnknownNameError, match=r"no column 'time' in log\.csv"):
        column(csv, "q1", "time", "s")


@pytest.mark.parametrize(
    ("text", "told"), [("-10.00,-0.0003\n-9.99,1\n", True), ("0,0\n1,1\n", True), ("t2,3\n1,1\n", False)]
)
def test_a_header_that_is_missing_is_told(text: str, told: bool, tmp_path: Path) -> None:
    """Its place is taken by the first row, whose numbers pass for names."""
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(UnknownNameError) as raised:
        column(tmp_path / "log.csv", "angle", "time", "s")
    assert ("names the columns, seems to be missing" in str(raised.value)) == told
    assert ("put a line of names before it, such as time,angle" in str(raised.value)) == told


def test_text_is_no_number(csv: Path) -> None:
    with pytest.raises(DataError, match=r"column 'name' holds string \(e\.g\. 'a'\), not numbers"):
        column(csv, "name")


def test_a_topic_entry_is_refused(csv: Path) -> None:
    entry = {"topic": "/q", "field": "data", "unit": "rad"}
    with pytest.raises(DataError, match=r"is a table\. Write column: NAME"):
        TableSource(csv, "time_ms", "ms").samples(channel_map("q", entry, ""))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("t;q\n0,0;1,5\n1,0;-,25\n", "columns between semicolons and numbers with decimal commas."),
        ("t;q\r\n0;1,5\r\n1;-0,25\r\n", "columns between semicolons and numbers with decimal commas."),
        ("t;q\n0.0;1.5\n1.0;-0.25\n", "columns between semicolons."),
        ("t\tq\n0.0\t1.5\n1.0\t-0.25\n", "columns between tabs."),
    ],
)
def test_the_header_tells_the_separator(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(text.encode())
    np.testing.assert_array_equal(column(path, "q", "t", "s"), [1.5, -0.25])
    assert [note.message for note in TableSource(path, "t", "s").notes] == [f"a.csv is read as {said}"]


def test_a_header_of_one_column_says_what_separates(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t q\n0 1\n")
    with pytest.raises(UnknownNameError, match=r"a\.csv \(one column: neither commas nor semicolons nor tabs"):
        column(tmp_path / "a.csv", "q", "t", "s")


@pytest.mark.parametrize("last", ["3", "3,"])
def test_a_last_row_that_breaks_off_is_left_out_and_told(tmp_path: Path, last: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"t,q,u\n0,1,1\n1,2,1\n{last}")
    np.testing.assert_array_equal(column(path, "q", "t", "s"), [1, 2])
    (note,) = TableSource(path, "t", "s").notes
    assert (note.kind, note.count) == ("cut", 2)
    assert note.message == "a.csv ends within a row (interrupted recording); 2 complete rows were kept."


def test_a_whole_table_has_no_note(csv: Path) -> None:
    assert TableSource(csv, "time_ms", "ms").notes == ()


def test_a_missing_whole_number_of_time_is_no_time(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,q\n5,1\n,2\n7,3\n")
    samples = TableSource(tmp_path / "a.csv", "t", "s").samples(channel_map("q", {"column": "q", "unit": "rad"}, ""))
    np.testing.assert_array_equal(samples.stamps["column"].elapsed, [0.0, np.nan, 2.0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "Cannot read"),
        ("t,q\n", "holds no rows"),
        ("t,q\n0,1\n1\n", "Cannot read"),
        ("t,q\n0,1\n1\n2,3", "Cannot read"),
        ("t,q\n0,1\n1,2,3", "Cannot read"),
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


@pytest.mark.parametrize("header", ['t,"q;raw;rad"', 't;"q, raw, rad"'])
def test_a_quoted_name_does_not_choose_the_separator(tmp_path: Path, header: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"{header}\n0{header[1]}1\n")
    assert load(path).table.column_names == ["t", header.split('"')[1]]


@pytest.mark.parametrize(
    "text",
    [
        "day;t;q\n15.08.2022;0,0;1,5\n15.08.2022;1,0;-0,25\n",
        "at;t;q\n10.30;0,0;1,5\n10.31;1,0;-0,25\n",
        "version;t;q\n1.2;0;1,5\n1.2;1;-0,25\n",
        't;q\n"0,0";"1,5"\n"1,0";"-0,25"\n',
        't,q\n0,"1,5"\n1,"-0,25"\n',
        "day;t;q\n" + "15.08.2022;0;0\n" * 9_998 + "15.08.2022;0;1,5\n15.08.2022;1;-0,25\n",
    ],
    ids=["dates", "times of day", "versions", "quoted", "quoted between commas", "late"],
)
def test_decimal_commas_are_seen_wherever_they_stand(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    source = TableSource(path, "t", "s")
    samples = source.samples(channel_map("sensor.x", {"column": "q", "unit": "1"}, ""))
    np.testing.assert_array_equal(samples.value[-2:], [1.5, -0.25])
    np.testing.assert_array_equal(samples.stamps["column"].elapsed[-2:], [0.0, 1.0])
    assert source.notes[0].message.endswith("and numbers with decimal commas.")


@pytest.mark.parametrize(
    ("text", "example"),
    [
        ("t;q;x\n0,0;1;1.500,25\n1,0;2;2,5\n", "1.500,25"),
        ("t;q;x\n0,0;1;1.500\n1,0;2;2.500\n", "1.500"),
        ("t;q;x\n0.0;1;1,500\n1.0;2;2,500\n", "1,500"),
        ('t,q,x\n0,1,"1,500"\n1,2,"2,500"\n', "1,500"),
        ("t;q;x\n0,0;1;2,5\n1,0;2;-\n", "-"),
    ],
    ids=["both", "points beside decimal commas", "commas beside points", "commas between quotes", "a dash"],
)
def test_numbers_with_thousands_separators_are_refused(tmp_path: Path, text: str, example: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    np.testing.assert_array_equal(column(path, "q", "t", "s"), [1, 2])
    with pytest.raises(DataError, match=rf"'x' holds string \(e\.g\. '{example}'\), .* without thousands separators"):
        column(path, "x", "t", "s")


@pytest.mark.parametrize(
    ("name", "row"), [("q [x,y,z]", "0;1.5"), ("q [a,b]", '0;"1,2,3"')], ids=["commas in a name", "and in a cell"]
)
def test_a_separator_of_names_is_one_of_rows(tmp_path: Path, name: str, row: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"t;{name}\n{row}\n")
    assert load(path).table.column_names == ["t", name]


@pytest.mark.parametrize(
    ("encoding", "said"), [("latin-1", "Latin-1"), ("utf-16", "UTF-16"), ("utf-8", ""), ("utf-8-sig", "")]
)
def test_names_are_read_in_the_encoding_that_they_were_saved_in(tmp_path: Path, encoding: str, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes("t;q [°];état\r\n0;1,5;prêt\r\n1;2,5;prêt\r\n".encode(encoding))
    rows = load(path)
    assert rows.table.column_names == ["t", "q [°]", "état"]
    assert rows.table["q [°]"].to_pylist() == [1.5, 2.5]
    told = [note.message for note in rows.notes if note.kind == "encoding"]
    assert told == ([f"a.csv is no UTF-8 text; its names are read as {said}."] if said else [])


def test_a_letter_of_two_bytes_that_is_read_in_two_parts_is_utf_8(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(text_encoding, "_CHUNK", 6)
    path = tmp_path / "a.csv"
    path.write_bytes("t,q [°]\n0,1\n".encode())  # the sixth and seventh bytes are one letter
    assert load(path).table.column_names == ["t", "q [°]"]


@pytest.mark.parametrize(
    ("content", "why"),
    [("t,q\n0,1\n".encode("utf-16") + b"\x31", "truncated data"), (b"t,q\n\0\x91", "it holds zero bytes")],
    ids=["half a letter of UTF-16", "no text"],
)
def test_what_is_no_text_is_refused(tmp_path: Path, content: bytes, why: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(DataError, match=rf"Cannot read .*a\.csv: .*{why}.* Expected a table; save it as UTF-8 text"):
        load(path)


def test_an_entry_of_a_list_column_is_a_column(tmp_path: Path) -> None:
    states = [[1.0, 2.0], [3.0, 4.0], None, [5.0]]
    pairs = pa.array([[1, 2], [3, 4], [5, 6], [7, 8]], pa.list_(pa.float32(), 2))
    table = pa.table({"t": [0.0, 0.1, 0.2, 0.3], "observation.state": states, "action": pairs})
    pyarrow.parquet.write_table(table, tmp_path / "a.parquet")
    np.testing.assert_array_equal(
        column(tmp_path / "a.parquet", "observation.state[1]", "t", "s"), [2, 4, np.nan, np.nan]
    )
    np.testing.assert_array_equal(column(tmp_path / "a.parquet", "action[1]", "t", "s"), [2, 4, 6, 8])
    for name, message in (
        ("action", r"holds lists\. Take one entry of each, e\.g\. action\[0\]"),
        ("action[2]", r"have up to 2 entries; there is no \[2\]"),
        ("t[0]", r"holds double, no lists"),
    ):
        with pytest.raises(DataError, match=message):
            column(tmp_path / "a.parquet", name, "t", "s")
    with pytest.raises(UnknownNameError, match=r"no column 'state\[0\]'.*observation\.state"):
        column(tmp_path / "a.parquet", "state[0]", "t", "s")


@pytest.mark.parametrize(("suffix", "pack"), [("gz", gzip.compress), ("bz2", bz2.compress), ("zst", None)])
def test_a_compressed_table_reads_as_the_plain_one(
    tmp_path: Path, suffix: str, pack: Callable[[bytes], bytes] | None
) -> None:
    path = tmp_path / f"log.csv.{suffix}"
    with pa.output_stream(path, compression="zstd") if pack is None else path.open("wb") as file:
        file.write(TEXT.encode() if pack is None else pack(TEXT.encode()))
    np.testing.assert_array_equal(column(path, "q1"), [0.5, np.nan, 1.5])
    assert (log_file.kind(path), log_file.stem(path)) == (".csv", "log")


def test_a_cut_compressed_table_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(TEXT.encode())[:-20])
    with pytest.raises(DataError, match="Cannot read"):
        load(path)
