"""Joints that an equality constraint couples, both measured."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main

AXIS = """<mujoco model="axis"><option timestep="0.001" integrator="RK4"/><worldbody>
  <body><joint name="motor" axis="0 1 0" damping="0.003"/>
    <geom type="cylinder" size="0.02 0.02" mass="0.3" contype="0" conaffinity="0"/></body>
  <body><joint name="schlitten" type="slide" axis="1 0 0" damping="12" range="-0.2 0.2" limited="true"/>
    <geom size="0.05" mass="3.6" contype="0" conaffinity="0"/></body></worldbody>
  <equality><joint joint1="schlitten" joint2="motor" polycoef="0 0.016 0 0 0" solref="0.002 1"
    solimp="0.999 0.999"/></equality>
  <actuator><motor name="antrieb" joint="motor" gear="0.4"/></actuator></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(names: tuple[str, str, str], status: int = 0) -> dict[str, Any]:
    """What init makes of logs in degrees, millimetres and amperes of a motor that drives a slide through a belt."""
    Path("axis.xml").write_text(AXIS)
    model, paths = mujoco.MjModel.from_xml_path("axis.xml"), []
    for seed in range(3):
        data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
        for k in range(4000):
            if k % 250 == 0:
                data.ctrl[0] = rng.uniform(-2.0, 2.0)
            rows.append([data.time, *data.qpos, data.ctrl[0]])
            mujoco.mj_step(model, data)
        time, motor, slide, current = np.array(rows[::4]).T
        angle = np.degrees(motor) + rng.normal(scale=0.01, size=len(time))
        place = 1e3 * slide + rng.normal(scale=0.003, size=len(time))
        values = {"Zeit [s]": time, names[0]: angle, names[1]: place, names[2]: current}
        paths.append(str(write_csv(Path(f"{seed}.csv"), values)))
    assert main(["init", "axis.xml", *paths]) == status
    return {} if status else yaml.safe_load(Path("mine/measurements/axis.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("names", "said"),
    [
        pytest.param(("Motorwinkel [°]", "Schlittenposition [mm]", "Iq [A]"), "by its name\n", id="units in the names"),
        pytest.param(
            ("motor_angle", "schlitten_position", "Iq [A]"), "in m it would leave the joint's range", id="no units"
        ),
    ],
)
def test_joints_that_an_equality_constraint_couples_are_read_by_name(
    names: tuple[str, str, str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Inverse dynamics knows nothing of the belt's force; so it accuses no command either."""
    found = proposed(names)
    read = {channel: (each["column"], each["unit"]) for channel, each in found["outputs"].items()}
    assert read == {"motor.position": (names[0], "deg"), "schlitten.position": (names[1], "mm")}
    assert found["commands"]["antrieb"]["column"] == "Iq [A]"
    told = capsys.readouterr().out
    assert "an equality constraint couples joints" in told
    assert said in told
    assert "commands" not in told.partition("Unsure:")[2].partition("Written:")[0]


def test_a_refusal_says_that_names_have_to_tell_coupled_joints(capsys: pytest.CaptureFixture[str]) -> None:
    proposed(("jawL_mm", "jawR_mm", "Fmot_N"), status=2)
    told = capsys.readouterr().err
    assert "has to be told by name: an equality constraint couples joints" in told
    assert "Are these logs of this robot?" not in told
