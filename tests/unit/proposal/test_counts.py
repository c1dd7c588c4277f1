"""Whole numbers without a unit may be counts of an encoder: where weight acts, the motion tells; else init says so."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main

COUNTS = 4096  # a turn
SCALE = COUNTS / (2 * np.pi)


def arm(axis: str, actuator: str = "") -> str:
    """An arm that hangs, or lies where its axis is upright."""
    return f"""<mujoco model="arm"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody>
      <body><joint name="turn" axis="{axis}" damping="0.03"/>
      <inertial mass="0.5" pos="0 0.02 -0.2" diaginertia="0.002 0.002 0.002"/></body></worldbody>
      <actuator>{actuator or '<motor name="motor" joint="turn"/>'}</actuator></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(
    xml: str, names: tuple[str, str], peak: float, of_command: float = 1.0, counts: float = SCALE
) -> dict[str, Any]:
    """What init makes of three logs whose angle is in counts, and whose command is so many times that of the model."""
    Path("arm.xml").write_text(xml)
    model, paths = mujoco.MjModel.from_xml_string(xml), []
    for seed in range(3):
        data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
        levels = rng.uniform(-peak, peak, 6)
        for k in range(3000):
            data.ctrl[:] = levels[k // 500]
            if k % 5 == 0:
                asked = of_command * data.ctrl[0]
                rows.append((data.time, asked if peak < 1 else np.round(asked), np.round(counts * data.qpos[0])))
            mujoco.mj_step(model, data)
        table = dict(zip(("time", *names), np.array(rows).T, strict=True))
        paths.append(str(write_csv(Path(f"logs/log_{seed}.csv"), table)))
    assert main(["init", "arm.xml", *paths, "name=it"]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


def test_weight_tells_counts_from_degrees() -> None:
    found = proposed(arm("0 1 0"), ("torque", "angle"), 0.9)["outputs"]["turn.position"]
    assert (found["column"], found["unit"]) == ("angle", "deg")
    assert found["scale"] == pytest.approx(360 / COUNTS, rel=0.03)  # an encoder of 4000 counts would do as well


@pytest.mark.parametrize("servo", [False, True])
def test_what_the_motion_does_not_tell_is_said_with_the_lines_to_write(
    servo: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """An arm about an upright axis is linear: any unit fits it."""
    position = '<position name="motor" joint="turn" kp="5" kv="0.5"/>' if servo else ""
    command = ("target", 1.0, SCALE) if servo else ("torque", 0.02, 1.0)
    proposed(arm("0 0 1", position), (command[0], "angle"), command[1], command[2])
    assert "angle holds whole numbers alone, as an encoder's counts are" in capsys.readouterr().out
    lines = Path("mine/measurements/it.yaml").read_text(encoding="utf-8").splitlines()
    assert "  # turn.position: {column: angle, unit: deg, scale: 0.087890625}" in lines
    assert ("  # motor: {column: target, unit: deg, scale: 0.087890625}" in lines) == servo
    assert any("0.09 of 4000" in line for line in lines)
    if not servo:
        (line,) = (line for line in lines if line.startswith("  # motor: "))
        said = yaml.safe_load(line.removeprefix("  # "))["motor"]
        assert said["scale"] == pytest.approx(1.0, rel=0.1)  # the torque is in N·m


def test_rests_at_a_command_of_a_known_unit_tell_the_counts(capsys: pytest.CaptureFixture[str]) -> None:
    found = proposed(
        arm("0 0 1", '<position name="motor" joint="turn" kp="5" kv="0.5"/>'), ("target_deg", "angle"), 1.0, 180 / np.pi
    )
    assert found["outputs"]["turn.position"] == {"column": "angle", "unit": "deg", "scale": 0.087890625}
    assert found["commands"]["motor"] == {"column": "target_deg", "unit": "deg"}
    assert "counts" not in capsys.readouterr().out


def test_a_command_in_millimetres_tells_the_counts_of_a_slide(capsys: pytest.CaptureFixture[str]) -> None:
    """41 counts a millimetre are no metres, whatever the servo's gains are."""
    cart = """<mujoco model="arm"><option timestep="0.002" integrator="RK4"/><worldbody><body>
      <joint name="rail" type="slide" axis="1 0 0" damping="3"/>
      <geom type="box" size="0.1 0.05 0.05" mass="1"/></body></worldbody>
      <actuator><position name="drive" joint="rail" kp="400" kv="30"/></actuator></mujoco>"""
    found = proposed(cart, ("target_mm", "enc"), 0.05, 1e3, counts=41e3)
    assert found["outputs"]["rail.position"] == {
        "column": "enc",
        "unit": "mm",
        "scale": pytest.approx(1 / 41, rel=0.03),
    }
    assert found["commands"]["drive"] == {"column": "target_mm", "unit": "mm"}
    page = capsys.readouterr().out
    assert "enc holds whole numbers alone, and is read in counts of 0.02" in page
    assert "Logs of a servo mostly have one unit" not in page


@pytest.mark.parametrize("name", ["angle_deg", "angle_rad"])
def test_a_unit_in_the_name_is_believed(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    proposed(arm("0 0 1"), ("torque", name), 0.02)
    assert "counts" not in capsys.readouterr().out
