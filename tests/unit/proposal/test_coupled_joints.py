"""Joints that an equality constraint couples, both measured."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main


def test_joints_that_an_equality_constraint_couples_are_read_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A motor that drives a slide through a belt: inverse dynamics knows nothing of the belt's force."""
    monkeypatch.chdir(tmp_path)
    Path("axis.xml").write_text("""<mujoco model="axis"><option timestep="0.001" integrator="RK4"/><worldbody>
      <body><joint name="motor" axis="0 1 0" damping="0.003"/>
        <geom type="cylinder" size="0.02 0.02" mass="0.3" contype="0" conaffinity="0"/></body>
      <body><joint name="schlitten" type="slide" axis="1 0 0" damping="12"/>
        <geom size="0.05" mass="3.6" contype="0" conaffinity="0"/></body></worldbody>
      <equality><joint joint1="schlitten" joint2="motor" polycoef="0 0.016 0 0 0" solref="0.002 1"
        solimp="0.999 0.999"/></equality>
      <actuator><motor name="antrieb" joint="motor" gear="0.4"/></actuator></mujoco>""")
    model = mujoco.MjModel.from_xml_path("axis.xml")
    paths = []
    for seed in range(3):
        data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
        for k in range(4000):
            if k % 250 == 0:
                data.ctrl[0] = rng.uniform(-2.0, 2.0)
            rows.append([data.time, *data.qpos, data.ctrl[0]])
            mujoco.mj_step(model, data)
        time, motor, slide, current = np.array(rows[::4]).T
        columns = {"Zeit [s]": time, "Motorwinkel [°]": np.degrees(motor) + rng.normal(scale=0.01, size=len(time))}
        columns |= {"Schlittenposition [mm]": 1e3 * slide + rng.normal(scale=0.003, size=len(time)), "Iq [A]": current}
        paths.append(str(write_csv(Path(f"{seed}.csv"), columns)))
    assert main(["init", "axis.xml", *paths]) == 0
    found = yaml.safe_load(Path("mine/measurements/axis.yaml").read_text(encoding="utf-8"))
    read = {channel: (each["column"], each["unit"]) for channel, each in found["outputs"].items()}
    assert read == {
        "motor.position": ("Motorwinkel [°]", "deg"),
        "schlitten.position": ("Schlittenposition [mm]", "mm"),
    }
    assert found["commands"]["antrieb"]["column"] == "Iq [A]"
    assert "an equality constraint couples joints" in capsys.readouterr().out
