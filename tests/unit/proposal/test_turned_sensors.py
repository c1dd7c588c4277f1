"""Sensors that are mounted upside down, or whose unit nobody says, on machines of which not every joint is measured."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main

WHEEL = """<mujoco model="it"><option timestep="0.001" integrator="implicitfast"/><worldbody><body name="rod">
  <joint name="pivot" axis="1 0 0" damping="0.0008"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.14" size="0.008" mass="0.12"/><site name="imu"/>
  <body name="wheel" pos="0 0 -0.14"><joint name="spin" axis="1 0 0" damping="1e-5"/>
    <geom type="cylinder" size="0.037 0.01" euler="0 90 0" mass="0.3" contype="0" conaffinity="0"/></body>
</body></worldbody><actuator><motor name="motor" joint="spin" gear="0.03"/></actuator>
<sensor><gyro name="gyro" site="imu"/></sensor></mujoco>"""


@pytest.mark.parametrize("sign", [1, -1])
def test_a_gyroscope_that_counts_the_other_way_is_turned(
    sign: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("it.xml").write_text(WHEEL)
    assert main(["init", "it.xml", *(_log(seed, sign) for seed in range(3))]) == 0
    page = yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))
    assert page["outputs"]["sensor.gyro.x"].get("sign", 1) == sign
    assert page["outputs"]["spin.velocity"] == {"column": "spin_rpm", "unit": "rpm"}
    assert ("sensor.gyro.x is read with the other sign" in capsys.readouterr().out) == (sign < 0)


def test_degrees_that_a_gyroscope_does_not_say_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("it.xml").write_text(WHEEL)
    assert main(["init", "it.xml", *(_log(seed, 1, "gyro_x") for seed in range(3))]) == 0
    told = capsys.readouterr().out
    assert "if it is in deg/s and called rad/s" in told
    assert (
        "If its unit in measurements.outputs.sensor.gyro.x is rad/s, write deg/s; else multiply its scale by 0.01745."
        in told
    )


def _log(seed: int, sign: int, name: str = "gyro_x_dps") -> str:
    """A run of a machine whose rod is a tenth heavier, at 500 Hz."""
    rng, rows = np.random.default_rng(seed), []
    model = mujoco.MjModel.from_xml_string(WHEEL.replace('mass="0.12"', 'mass="0.132"'))
    data, levels = mujoco.MjData(model), rng.uniform(-3.0, 3.0, 40)
    for k in range(4000):
        data.ctrl[0] = levels[k // 100]
        if k % 2 == 0:
            rows.append([data.time, data.ctrl[0], *data.qvel])
        mujoco.mj_step(model, data)
    time, current, gyro, wheel = np.array(rows).T
    noise = rng.normal(scale=(0.1, 1.0), size=(len(time), 2))
    columns = {name: sign * np.degrees(gyro) + noise[:, 0], "spin_rpm": wheel * 30 / np.pi + noise[:, 1]}
    return str(write_csv(Path(f"{seed}.csv"), {"t": time, "current_A": current, **columns}))
