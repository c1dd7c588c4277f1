"""Series that some logs lack: init says which log, and reads the others."""

from pathlib import Path

import pytest
import yaml
from own_robot import MJCF, plain_logs

from dr_lab.__main__ import main
from dr_lab.measurements.inventory import Place
from dr_lab.proposal.partly_held import partly_held


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


def renamed(path: Path, **names: str) -> None:
    header, rest = path.read_text().split("\n", 1)
    path.write_text(",".join(names.get(name, name) for name in header.split(",")) + "\n" + rest)


def test_a_command_that_one_log_lacks_is_told_with_that_log(capsys: pytest.CaptureFixture[str]) -> None:
    logs = plain_logs(Path("logs"))
    renamed(logs[1], elbow_torque="elbow_tau")
    assert main(["init", "two.xml", *map(str, logs)]) == 0
    told = capsys.readouterr().out
    assert "elbow_torque is read in no log, as log_1 holds no numbers of that name. Name it alike in all logs" in told
    assert "elbow_tau is read in no log, as log_0, log_2 hold no numbers of that name." in told
    commands = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))["commands"]
    assert [*commands] == ["shoulder"]


def test_a_refusal_says_which_log_lacks_a_position(capsys: pytest.CaptureFixture[str]) -> None:
    logs = plain_logs(Path("logs"))
    renamed(logs[2], shoulder_pos="a", elbow_pos="b", shoulder_torque="c", elbow_torque="d")
    assert main(["init", "two.xml", *map(str, logs)]) == 2
    told = capsys.readouterr().err
    assert "The logs have no series of numbers in common. shoulder_pos, " in told
    assert "are read in no log, as log_2 holds no numbers of these names." in told


def test_what_all_logs_hold_or_is_told_already_is_not_spoken_of() -> None:
    q, u = (Place("", name, "", "column") for name in "qu")
    assert [*partly_held({"a": [q, u], "b": [u, q]})] == []
    assert [*partly_held({"a": [q, u], "b": [q]}, {"u"})] == []
    (said,) = partly_held({"a": [q, u], "b": [q]})
    assert said.startswith("u is read in no log, as b holds no numbers of that name.")
