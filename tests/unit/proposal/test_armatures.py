"""A motor that is weaker or stronger than the model says: the ratio of force to inertia is free."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main

ARMATURE, DAMPING, PEAK = 0.002, 0.005, 0.05  # kg·m², N·m·s/rad, N·m


def rotor(gain: float) -> str:
    """A rotor about an upright axis whose shape weighs next to nothing, and a motor of so many N·m per 1 of ctrl."""
    return f"""<mujoco model="rotor"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody>
      <body name="disc"><joint name="hub" axis="0 0 1" armature="{ARMATURE}" damping="{DAMPING}"/>
      <geom type="cylinder" size="0.01 0.005" mass="0.01" contype="0" conaffinity="0"/></body></worldbody>
      <actuator><motor name="motor" joint="hub" gear="{gain}"/></actuator></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(gain: float) -> dict[str, Any]:
    """What init frees where the motor is so many times as strong as in the model."""
    Path("rotor.xml").write_text(rotor(1.0))
    model, paths = mujoco.MjModel.from_xml_string(rotor(gain)), []
    for seed in range(3):
        data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
        levels = rng.uniform(-PEAK, PEAK, 20)
        for k in range(3000):
            data.ctrl[:] = levels[k // 150]
            if k % 5 == 0:
                rows.append((data.time, data.ctrl[0], data.qpos[0] + rng.normal(scale=1e-4)))
            mujoco.mj_step(model, data)
        time, torque, angle = np.array(rows).T
        columns = {"time": time, "torque": torque, "hub_rad": angle}
        paths.append(str(write_csv(Path(f"logs/log_{seed}.csv"), columns)))
    assert main(["init", "rotor.xml", *paths, "name=it"]) == 0
    return yaml.safe_load(Path("mine/model/it.yaml").read_text(encoding="utf-8"))["parameters"]


@pytest.mark.parametrize("gain", [0.5, 0.73, 1.7])
def test_inertia_and_damping_over_the_gain_lie_within_the_bounds(
    gain: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """The motor's own gain stays: a motion shows the three only up to one factor."""
    free = proposed(gain)
    assert [*free] == ["hub.armature", "hub.damping"]
    for name, value in (("armature", ARMATURE / gain), ("damping", DAMPING / gain)):
        entry = free[f"hub.{name}"]
        assert 1.2 * entry["low"] < value < entry["high"] / 1.2
        assert entry["low"] <= (ARMATURE if name == "armature" else DAMPING) <= entry["high"]
    told = capsys.readouterr().out
    assert "No known force drives" not in told
    assert f"hub.armature is free: motor moves hub {gain:.2g} ± " in told


def test_a_motor_as_strong_as_the_model_says_frees_no_inertia() -> None:
    assert [*proposed(1.0)] == ["hub.damping"]
