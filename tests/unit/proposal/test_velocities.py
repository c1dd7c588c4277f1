"""Columns that are velocities of joints whose positions no column holds."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main

ROTOR = """<mujoco model="it"><option timestep="0.002"/><worldbody><body name="disk">
  <joint name="shaft" axis="0 0 1" damping="0.002"/><geom name="disk" type="cylinder" size="0.05 0.01" mass="0.5"/>
</body></worldbody><actuator><motor name="motor" joint="shaft"/></actuator></mujoco>"""
DEG = 180 / np.pi
EVERY = 10  # steps


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("it.xml").write_text(ROTOR)


def proposed(name: str, per_rad: float, *, integrated: bool = False, command: str = "u") -> dict[str, Any]:
    """What init makes of a rotor's speed, or its angle, in a column of that name; the rotor turns up to 25 rad/s."""
    model, paths = mujoco.MjModel.from_xml_string(ROTOR), []
    for seed in range(3):
        rng, data, rows = np.random.default_rng(seed), mujoco.MjData(model), []
        levels = np.repeat(rng.uniform(-0.05, 0.05, 80), rng.integers(20, 120, 80))  # steps at uneven times
        for k in range(4000):
            data.ctrl[:] = levels[k]
            if k % EVERY == 0:
                moved = data.qpos[0] if integrated else data.qvel[0]
                rows.append((data.time, data.ctrl[0], per_rad * (moved + rng.normal(scale=1e-3))))
            mujoco.mj_step(model, data)
        paths.append(
            str(write_csv(Path(f"logs/{seed}.csv"), dict(zip(("t", command, name), np.array(rows).T, strict=True))))
        )
    assert main(["init", "it.xml", *paths]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("name", "per_rad", "unit"), [("y", 1.0, "rad/s"), ("c9", DEG, "deg/s"), ("speed", DEG, "deg/s")]
)
def test_a_column_that_explains_nothing_but_as_a_velocity_is_one(name: str, per_rad: float, unit: str) -> None:
    found = proposed(name, per_rad)
    assert found["outputs"] == {"shaft.velocity": {"column": name, "unit": unit}}
    assert found["commands"] == {"motor": {"column": "u", "unit": "N·m"}}
    if name != "speed":
        assert "hardly less than all if this were the position" in Path("mine/measurements/it.yaml").read_text("utf-8")


@pytest.mark.parametrize(("name", "integrated"), [("y", True), ("angle_rad", False)])
def test_a_position_and_what_is_named_one_stay_positions(name: str, integrated: bool) -> None:
    found = proposed(name, 1.0, integrated=integrated)
    assert found["outputs"] == {"shaft.position": {"column": name, "unit": "rad"}}


def test_a_named_velocity_is_believed_before_a_nameless_column_is_called_a_position() -> None:
    found = proposed("rpm", 30 / np.pi, command="Output")
    assert found["outputs"] == {"shaft.velocity": {"column": "rpm", "unit": "rpm"}}
    assert found["commands"] == {"motor": {"column": "Output", "unit": "N·m"}}
