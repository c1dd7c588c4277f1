"""Logs with too few rows are left out by name; they do not hide the others."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


def shortened(path: Path, rows: int) -> None:
    path.write_text("\n".join(path.read_text().splitlines()[: rows + 1]) + "\n")


def test_a_short_log_is_left_out_by_name_with_its_rows(capsys: pytest.CaptureFixture[str]) -> None:
    """It is the first, in which a clock is looked for as well."""
    logs = plain_logs(Path("logs"))
    shortened(logs[0], 1)
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    told = capsys.readouterr().out
    assert "log_0: It holds 1 row of numbers; expected at least 20." in told
    found: dict[str, Any] = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))
    assert {*found["fit"], *found["held_out"]} == {"log_1", "log_2"}
    assert {*found["outputs"]} == {"shoulder.position", "elbow.position"}


def test_logs_that_are_all_short_are_refused_with_their_rows(capsys: pytest.CaptureFixture[str]) -> None:
    logs = plain_logs(Path("logs"), 2)
    shortened(logs[0], 12)
    shortened(logs[1], 19)
    assert main(["init", "two.xml", *map(str, logs)]) == 2
    told = capsys.readouterr().err
    assert "Each log is too short. log_0: It holds 12 rows of numbers; expected at least 20. log_1: It holds 19" in told
    assert not Path("mine").exists()
