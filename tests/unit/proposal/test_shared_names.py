"""Columns that share a name or have none: init reads the others."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main
from dr_lab.errors import DataError
from dr_lab.measurements.inventory import columns_of
from dr_lab.proposal.time_column import find_clock


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


@pytest.mark.parametrize(
    ("more", "cells", "told"),
    [
        (",,", ",,", ""),  # as spreadsheets write
        (",", ",7", ""),
        (",n,n", ",1,2", "Unsure:\n  - log_0.csv: 2 columns are called n, so that none of them is read. Give each a"),
    ],
)
def test_columns_that_nothing_tells_apart_are_left_out(
    more: str, cells: str, told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = plain_logs(Path("logs"), 1)
    header, *rows = logs[0].read_text().splitlines()
    logs[0].write_text("\n".join([header + more, *(row + cells for row in rows)]) + "\n")
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    said = capsys.readouterr().out
    assert told in said
    assert ("columns are called" in said) == bool(told)
    found: dict[str, Any] = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))
    assert [each["column"] for each in found["outputs"].values()] == ["shoulder_pos", "elbow_pos"]


def test_a_clock_among_columns_of_one_name(capsys: pytest.CaptureFixture[str]) -> None:
    """A clock that is there twice is none, which the refusal says."""
    rows = [f"{0.01 * k},{0.01 * k},{0.01 * k},{k % 7}" for k in range(100)]
    Path("a.csv").write_text("\n".join(["t,stamp,stamp,q", *rows]))
    assert find_clock(Path("a.csv")).axis.column == "t"
    assert [place.path for place in columns_of(Path("a.csv"))] == ["t", "q"]
    Path("a.csv").write_text("\n".join(["step,stamp,stamp,q", *rows]))
    with pytest.raises(DataError, match="Columns that rise, but are not called time: step"):
        find_clock(Path("a.csv"))
    assert main(["init", "two.xml", "a.csv"]) == 2
    assert "a.csv: 2 columns are called stamp" in capsys.readouterr().err
