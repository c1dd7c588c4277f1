"""Times that go back within a log: init says how much is left out."""

from pathlib import Path

import numpy as np
import pytest
from bags import write_bag
from own_robot import JOINTS, MJCF, Motion, plain_logs

from dr_lab.__main__ import main


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


@pytest.mark.parametrize("numbered", [False, True])
def test_runs_in_one_file_are_told_unless_a_column_numbers_them(
    capsys: pytest.CaptureFixture[str], *, numbered: bool
) -> None:
    header, *rows = plain_logs(Path("logs"), 1)[0].read_text().splitlines()
    runs = [[f"{row},{run}" if numbered else row for row in rows] for run in range(3)]
    text = [f"{header},run" if numbered else header, *(row for run in runs for row in run)]
    Path("all.csv").write_text("\n".join(text) + "\n")
    assert main(["init", "two.xml", "all.csv"]) == 0
    told = capsys.readouterr().out
    assert ("3 logs" in told) == numbered
    # Two rows of the later runs are as late as the last of the first, which they repeat.
    said = "all: the time goes back 2 times; 2398 of 3600 rows are left out, as they lie before earlier ones. If they"
    assert (said in told) != numbered


def test_header_stamps_that_are_set_back_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    motion = Motion(0)
    stamped = motion.time - np.where(motion.time < 4.0, 0.0, 1.0)
    log = write_bag(Path("run"), JOINTS, motion.time, motion.position, command=motion.torque, stamped=stamped)
    assert main(["init", "two.xml", str(log)]) == 0
    told = capsys.readouterr().out
    assert "run: the time of /joint_states goes back 1 time; " in told
    assert (
        "of 1200 messages are left out, as they lie before earlier ones. Use clock: log, or cut the log there." in told
    )
