"""`dr-lab init` where the names leave open which of several joints a column is."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main

TWO = """<mujoco><worldbody><body>
  <joint name="{first}" axis="{axis}"/><inertial mass="0.5" pos="0 0 -0.1" diaginertia="1e-3 1e-3 1e-3"/>
  <body pos="0 0 -0.1"><joint name="{second}" axis="0 1 0"/>
    <inertial mass="0.2" pos="0 0 {below}" diaginertia="3e-4 6e-4 3e-4"/></body>
</body></worldbody></mujoco>"""
ANGLE = 0.5 * np.cos(7.0 * np.arange(0.0, 6.0, 0.01))  # rad


@pytest.mark.parametrize(
    ("xml", "joint", "other"),
    [
        (TWO.format(first="pivot", axis="0 1 0", second="wheel", below=0), "pivot", "wheel"),
        (TWO.format(first="table", axis="0 0 1", second="arm", below=-0.1), "arm", "table"),
    ],
    ids=("a wheel on a pendulum", "an arm on a turntable"),
)
def test_one_column_is_one_joint_that_gravity_moves(
    xml: str,
    joint: str,
    other: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(xml)
    log = str(
        write_csv(Path("log.csv"), {"time": np.asarray(0.01 * np.arange(len(ANGLE)), np.float64), "angle": ANGLE})
    )
    assert main(["init", "two.xml", log]) == 0
    outputs = yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8"))["outputs"]
    assert outputs == {f"{joint}.position": {"column": "angle", "unit": "rad"}}
    told = capsys.readouterr().out
    assert f"angle is read as that of {joint}; by its name it may as well be that of {other}" in told
