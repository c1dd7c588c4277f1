"""How init names the logs that are fitted and held out."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import yaml
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main
from dr_lab.errors import DataError
from dr_lab.measurements.inventory import Place
from dr_lab.measurements.split import find_files
from dr_lab.proposal.output import Output
from dr_lab.proposal.propose import Proposal
from dr_lab.proposal.split import split_logs
from dr_lab.proposal.survey import Series, Survey
from dr_lab.proposal.words import read_name
from dr_lab.trajectory import Signal


@pytest.mark.parametrize(
    ("start", "lasts", "named"),
    [
        (0.0, 5.995, "3.96"),
        (2000.0, 3.0, "2001.98"),
        (1234567.0, 0.3, "1234567.198"),
        (100.0, 3000.0, "2080"),
        (0.0123, 3e5, "198000"),
    ],
)
def test_a_log_is_cut_by_its_length_wherever_it_begins(start: float, lasts: float, named: str) -> None:
    """To three digits of what is fitted."""
    signal = Signal("sensor.0", "1", start + np.linspace(0.0, lasts, 300), np.zeros(300))
    series = Series(Place("", "q", "", "column"), read_name("", "q", ""), (signal,))
    output = Output("turn.position", (series,), "rad", 1, 0.0, wrap=False, why="")
    logs = Survey({"bag": Path("/x/bag.mcap")}, ("bag",), (series,), None)
    split = split_logs(cast("Proposal", SimpleNamespace(logs=logs, outputs=(output,))), {}, 0.34)
    assert (split.fit, split.held_out) == ((f"bag[:{named}]",), (f"bag[{named}:]",))
    assert f"its first {named} s fitted" in split.said(1)


def test_a_folder_with_brackets_is_found_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "run [1]"
    folder.mkdir()
    monkeypatch.chdir(folder)
    Path("two.xml").write_text(MJCF)
    logs = plain_logs(Path("logs"))
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    assert "refuse" not in capsys.readouterr().out
    found: dict[str, Any] = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))
    assert len(found["logs"]) == 1
    assert [*find_files(found["logs"])] == ["log_0", "log_1", "log_2"]


def test_a_folder_stands_for_all_its_logs_of_one_kind(tmp_path: Path) -> None:
    for name in ("b.csv", "a.csv", "notes.md"):
        (tmp_path / name).write_text("t,x\n0,1\n")
    assert find_files([str(tmp_path)]) == {"a": tmp_path / "a.csv", "b": tmp_path / "b.csv"}
    (tmp_path / "c.parquet").write_bytes(b"")
    with pytest.raises(DataError, match=r"logs of several kinds\. Name those of one, e\.g\. .*/\*\.csv"):
        find_files([str(tmp_path)])


def test_a_folder_without_logs_is_refused_and_what_it_holds_is_named(tmp_path: Path) -> None:
    (tmp_path / "notes.md").write_text("")
    with pytest.raises(DataError, match=r"is a folder; folder .* holds notes\.md\. Name logs\."):
        find_files([str(tmp_path)])
