"""Tables whose time is split into seconds and the rest of each: neither column alone is a clock."""

from pathlib import Path

import pytest

from dr_lab.errors import DataError
from dr_lab.proposal.time_column import find_clock


def table(folder: Path, header: str, parts: int, rate: int, *, more: str = "") -> Path:
    """Six seconds of a log that begins 0.4 s after a full second; `more` names a column of the whole time in s."""
    path, rows = folder / "a.csv", []
    for k in range(6 * rate):
        seconds, rest = divmod(4 * parts // 10 + k * parts // rate, parts)
        rows.append(f"{1_700_000_000 + seconds},{rest},{k % 7}" + (f",{k / rate}" if more else ""))
    path.write_text("\n".join([f"{header},q{more and ','}{more}", *rows]))
    return path


@pytest.mark.parametrize(
    ("header", "parts", "rate", "column"),
    [
        ("header.stamp.sec,header.stamp.nanosec", 10**9, 100, "time_ns"),
        ("header.stamp.sec,header.stamp.nanosec", 10**9, 10, "time_ns"),  # the rest falls back in every tenth row
        ("secs,nsecs", 10**9, 100, "time_ns"),
        ("tv_sec,tv_usec", 10**6, 200, "time_us"),
        ("stamp_s,stamp_ms", 10**3, 100, "time_ms"),
    ],
)
def test_a_split_clock_is_refused_with_a_formula(
    tmp_path: Path, header: str, parts: int, rate: int, column: str
) -> None:
    seconds, rest = header.split(",")
    with pytest.raises(DataError) as caught:
        find_clock(table(tmp_path, header, parts, rate))
    told = str(caught.value)
    assert f"{seconds} counts the seconds and {rest} the {column.removeprefix('time_')} of each" in told
    assert f"Add a column {column} that holds {parts} · {seconds} + {rest}." in told


def test_another_clock_stands_for_a_split_one(tmp_path: Path) -> None:
    path = table(tmp_path, "header.stamp.sec,header.stamp.nanosec", 10**9, 100, more="bag time")
    clock = find_clock(path)
    assert (clock.axis.column, clock.axis.unit, clock.group) == ("bag time", "s", None)


def test_a_whole_time_beside_its_seconds_is_a_clock(tmp_path: Path) -> None:
    rows = [f"{k // 100},{10 * k},{k % 7}" for k in range(300)]
    (tmp_path / "a.csv").write_text("\n".join(["time_s,time_ms,q", *rows]))
    clock = find_clock(tmp_path / "a.csv")
    assert (clock.axis.column, clock.axis.unit) == ("time_ms", "ms")
