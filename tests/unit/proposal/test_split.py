"""How init names the logs that are fitted and held out."""

from pathlib import Path
from typing import Any

import pytest
import yaml
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main
from dr_lab.measurements.split import find_files


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
