"""Servos that come to rest at their commands, which says what the two have in common."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from own_robot import write_csv

from dr_lab.__main__ import main
from dr_lab.trajectory import Array

SAMPLE = 0.02  # s
FASTEST, GAIN = 4.6, 20.0  # rad/s and 1/s, of a hobby servo: it turns as fast as it can until it is nearly there
DEG = 180 / np.pi


def robot(kp: float) -> str:
    """An arm under a servo that saturates far below what its gain would make of its largest error."""
    return f"""<mujoco model="arm"><compiler angle="radian"/><option timestep="0.002" integrator="RK4"/><worldbody>
      <body>
      <joint name="turn" axis="0 1 0" armature="0.005" damping="0.1"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.08" size="0.008" mass="0.1"/></body></worldbody>
      <actuator><position name="servo" joint="turn" kp="{kp}" kv="1" forcerange="-2.7 2.7"/></actuator></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def log(seed: int, hold: int = 40) -> tuple[Array, Array, Array]:
    """Time, target and angle of a geared servo, rad, whose targets hold for so many samples."""
    rng = np.random.default_rng(seed)
    target = np.repeat(rng.uniform(-1.8, 1.8, 240 // hold), hold)
    angle = np.zeros(len(target))
    for k in range(1, len(angle)):
        angle[k] = angle[k - 1] + SAMPLE * np.clip(GAIN * (target[k - 1] - angle[k - 1]), -FASTEST, FASTEST)
    time = np.asarray(SAMPLE * np.arange(len(target)), np.float64)
    return time, target, angle + rng.normal(scale=1e-3, size=len(angle))


def proposed(kp: float, names: tuple[str, str], scales: tuple[float, float], hold: int = 40) -> dict[str, Any]:
    """What init makes of logs whose target and angle are so many times those in rad."""
    Path("arm.xml").write_text(robot(kp))
    paths = []
    for seed in range(3):
        time, target, angle = log(seed, hold)
        columns = {"t": time, names[0]: scales[0] * target, names[1]: scales[1] * angle}
        paths.append(str(write_csv(Path(f"logs/log_{seed}.csv"), columns)))
    assert main(["init", "arm.xml", *paths, "name=it"]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("kp", [5.0, 50.0, 500.0])
def test_the_stiffness_of_the_model_does_not_decide_the_unit(kp: float, capsys: pytest.CaptureFixture[str]) -> None:
    found = proposed(kp, ("target", "position"), (1.0, 1.0))
    assert found["outputs"] == {"turn.position": {"column": "position", "unit": "rad"}}
    assert found["commands"] == {"servo": {"column": "target", "unit": "rad"}}
    told = capsys.readouterr().out
    assert "turn comes to rest at it" in told
    assert "Was the machine on?" not in told


@pytest.mark.parametrize(
    ("names", "scales", "angle", "target"),
    [
        (("target", "position"), (1.0, -1.0), {"unit": "rad"}, {"unit": "rad", "sign": -1}),
        (("target_deg", "position"), (DEG, DEG), {"unit": "deg"}, {"unit": "deg"}),
        (("target_deg", "position"), (DEG, 1.0), {"unit": "rad"}, {"unit": "deg"}),
        (("target", "position_deg"), (1.0, DEG), {"unit": "deg"}, {"unit": "rad"}),
    ],
)
def test_rests_tell_sign_and_unit(
    names: tuple[str, str], scales: tuple[float, float], angle: dict[str, Any], target: dict[str, Any]
) -> None:
    found = proposed(50.0, names, scales)
    assert found["outputs"] == {"turn.position": {"column": names[1], **angle}}
    assert found["commands"] == {"servo": {"column": names[0], **target}}


def test_a_name_that_the_rests_contradict_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    found = proposed(50.0, ("target_deg", "position_rad"), (1.0, 1.0))
    assert found["commands"] == {"servo": {"column": "target_deg", "unit": "rad"}}
    assert "named deg, but turn comes to rest where rad would put it" in capsys.readouterr().out


def test_units_that_differ_without_a_rest_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    found = proposed(50.0, ("target", "position_deg"), (1.0, DEG), hold=15)  # 0.3 s, in which nothing rests
    assert found["commands"]["servo"]["unit"] == "rad"
    assert "position_deg is read in deg, but its command target in rad" in capsys.readouterr().out
