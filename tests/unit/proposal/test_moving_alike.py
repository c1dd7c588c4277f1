"""Two columns that may both be a joint's position, as of a motor and a link: init says which of them it reads."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from own_robot import MJCF, Motion, write_csv

from dr_lab.__main__ import main
from dr_lab.proposal.grid import Grid, path_of
from dr_lab.proposal.grid import Path as Path_
from dr_lab.proposal.survey import Series
from dr_lab.trajectory import Array

GEAR = 20.0


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


def logs(name: str, gear: float, noise: float) -> list[str]:
    """Logs of both joints and torques, and of the elbow's motor, which follows its link by `gear` and its own noise."""
    paths = []
    for seed in range(3):
        motion, rng = Motion(seed, seconds=4.0), np.random.default_rng(seed)
        (shoulder, elbow), (first, second) = motion.position.T, motion.torque.T
        motor: Array = gear * (elbow + noise * rng.normal(size=len(elbow)))
        columns = {"time": motion.time, name: motor, "elbow_q_l": elbow, "shoulder_q_l": shoulder}
        columns |= {"elbow_torque": second, "shoulder_torque": first}
        paths.append(str(write_csv(Path(f"log_{seed}.csv"), columns)))
    return paths


@pytest.mark.parametrize(("name", "gear"), [("elbow_q_m", GEAR), ("elbow_q_m", 1.0), ("motor_angle", -GEAR)])
def test_the_side_of_a_gear_that_is_not_read_is_told(
    name: str, gear: float, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["init", "two.xml", *logs(name, gear, 2e-3)]) == 0
    outputs = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))["outputs"]
    read = outputs["elbow.position"]["column"]
    other = name if read == "elbow_q_l" else "elbow_q_l"
    assert abs(gear) == 1.0 or read == "elbow_q_l"
    told = capsys.readouterr().out
    far = f"{abs(gear):.0f} times as far" + (", the other way" if gear < 0 else "")
    assert f"{other} and {read} move alike ({other} {far}), and only {read} is read, as elbow.position." in told
    remedy = f"read it in place of {read}, with scale: {1 / abs(gear):g}{', sign: -1' if gear < 0 else ''}."
    assert f"If {other} is what elbow of the model stands for, such as the motor's side of a gear, {remedy}" in told
    assert told.count("move alike") == 1


@pytest.mark.parametrize("gear", [1.0, 180 / np.pi], ids=["copy", "degrees"])
def test_copies_are_not_spoken_of(gear: float, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "two.xml", *logs("elbow_q_m", gear, 0.0)]) == 0
    assert "move alike" not in capsys.readouterr().out


def test_each_series_is_smoothed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a quadruped's many pairs of columns, smoothing each anew took more than half of init's time."""
    names: list[str] = []

    def spied(series: Series, grid: Grid, cutoff: float) -> Path_:
        names.append(str(series.place))
        return path_of(series, grid, cutoff)

    monkeypatch.setattr("dr_lab.proposal.moving_alike.path_of", spied)
    assert main(["init", "two.xml", *logs("elbow_q_m", GEAR, 2e-3)]) == 0
    assert "elbow_q_m" in names
    assert len(names) == len({*names})
