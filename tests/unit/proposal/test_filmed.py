"""`dr-lab init` on places that a camera saw: x and y of a point of the machine, which are no angles."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main
from dr_lab.trajectory import Array

LENGTH = 0.8  # m
BOB = f"""<mujoco model="bob"><option timestep="0.002" integrator="RK4"/><worldbody><body>
  <joint name="{{joint}}" axis="0 -1 0"/>
  <geom type="sphere" size="0.01" pos="0 0 -{LENGTH}" mass="0.2"/><site name="ball" pos="0 0 -{LENGTH}"/>
</body></worldbody><sensor>{{sensor}}</sensor></mujoco>"""
SENSOR = '<framepos name="ball" objtype="site" objname="ball"/>'
SLIDE = BOB.replace('axis="0 -1 0"', 'type="slide" axis="1 0 0"')


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def filmed() -> dict[str, Array]:
    """A small swing by its closed form, as a camera sees it: x to the right, y upwards."""
    rng = np.random.default_rng(0)
    time = np.asarray(0.02 * np.arange(400), np.float64)
    angle = 0.1 * np.cos(np.sqrt(9.81 / LENGTH) * time) + rng.normal(scale=1e-4, size=len(time))
    return {"time": time, "x": LENGTH * np.sin(angle), "y": -LENGTH * np.cos(angle), "swing_angle": angle}


def outputs(xml: str, *columns: str) -> dict[str, Any]:
    """Of the measurements that are proposed for a log with these columns."""
    Path("bob.xml").write_text(xml)
    log = write_csv(Path("log.csv"), {name: values for name, values in filmed().items() if name in ("time", *columns)})
    assert main(["init", "bob.xml", str(log)]) == 0
    return yaml.safe_load(Path("mine/measurements/bob.yaml").read_text(encoding="utf-8"))["outputs"]


def test_axes_of_a_picture_are_those_of_a_sensor_that_moves_so(capsys: pytest.CaptureFixture[str]) -> None:
    """The picture's y is upwards, where the model has z."""
    found = outputs(BOB.format(joint="swing", sensor=SENSOR), "x", "y")
    assert found == {"sensor.ball.x": {"column": "x", "unit": "m"}, "sensor.ball.z": {"column": "y", "unit": "m"}}
    told = capsys.readouterr().out
    assert "the model does not move along y, so that the column y is read as its axis z" in told
    assert "refuse" not in told


@pytest.mark.parametrize("joint", ["swing", "hook"])
def test_a_hinge_is_the_angle_beside_the_places(joint: str) -> None:
    found = outputs(BOB.format(joint=joint, sensor=""), "x", "y", "swing_angle")
    assert found == {f"{joint}.position": {"column": "swing_angle", "unit": "rad"}}


def test_a_place_that_is_read_as_an_angle_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert list(outputs(BOB.format(joint="swing", sensor=""), "x")) == ["swing.position"]
    assert "x is a length by its name, but read as the angle of swing" in capsys.readouterr().out


def test_a_slide_is_what_its_column_says_whatever_sensors_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    found = outputs(SLIDE.format(joint="cart", sensor=SENSOR), "x")
    assert found == {"cart.position": {"column": "x", "unit": "m"}}
    assert "length by its name" not in capsys.readouterr().out
