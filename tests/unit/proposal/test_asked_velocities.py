"""Velocities that are asked for: commands of velocity servos, and of nothing else."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from played_logs import played, write_log

from dr_lab.__main__ import main
from dr_lab.proposal.words import read_name

CART = """<mujoco model="it"><option timestep="0.001" integrator="RK4"/><worldbody><body name="cart">
  <joint name="rail" type="slide" axis="1 0 0" damping="0.5"/><geom type="box" size="0.1 0.05 0.05" mass="2"/>
  <body name="pole"><joint name="pivot" axis="0 1 0" damping="0.001"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.01" mass="0.3"/></body>
</body></worldbody><actuator>{}</actuator></mujoco>"""
SERVO = CART.format('<velocity name="rail_drive" joint="rail" kv="40"/>')
INTEGRATED = CART.format('<intvelocity name="rail_drive" joint="rail" kp="200" kv="40" actrange="-2 2"/>')
MOTOR = CART.format('<motor name="rail_drive" joint="rail"/>')


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def proposed(mjcf: str, header: str, *, factor: float = 1.0) -> dict[str, Any]:
    """What init makes of a cart's table of time, way, angle and control; the control lies within ±0.5."""
    Path("it.xml").write_text(mjcf)
    paths = []
    for seed in range(3):
        levels = np.random.default_rng(seed).uniform(-0.5, 0.5, 40)
        time, place, control = played(mjcf, [0.0, 0.3], 4.0, lambda t, u=levels: [u[int(t / 0.1)]], seed)
        paths.append(write_log(str(seed), header, time, place, factor * control))
    assert main(["init", "it.xml", *paths]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("column", "factor", "unit"),
    [("rail_speed_setpoint_mps", 1.0, "m/s"), ("speed_cmd_mmps", 1e3, "mm/s"), ("rail_speed_setpoint", 1.0, "m/s")],
)
def test_a_velocity_that_is_asked_for_commands_a_velocity_servo(column: str, factor: float, unit: str) -> None:
    found = proposed(SERVO, f"t,rail_pos,pivot_pos,{column}", factor=factor)
    assert found["commands"] == {"rail_drive": {"column": column, "unit": unit}}
    assert list(found["outputs"]) == ["rail.position", "pivot.position"]


def test_a_velocity_that_is_asked_for_commands_a_servo_that_holds_its_integral(
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = proposed(INTEGRATED, "t,rail_pos,pivot_pos,rail_speed_setpoint")
    assert found["commands"] == {"rail_drive": {"column": "rail_speed_setpoint", "unit": "m/s"}}
    told = capsys.readouterr().out
    assert "explains 100% of what rail needs; gain 1" in told
    assert "Unsure" not in told


def test_the_motion_tells_the_unit_of_an_integrated_command() -> None:
    found = proposed(INTEGRATED, "t,rail_pos,pivot_pos,rail_speed_setpoint", factor=1e3)
    assert found["commands"] == {"rail_drive": {"column": "rail_speed_setpoint", "unit": "mm/s"}}


def test_a_velocity_that_is_asked_for_commands_no_motor(capsys: pytest.CaptureFixture[str]) -> None:
    """Its numbers are the motor's force, which its name rules out."""
    found = proposed(MOTOR, "t,rail_pos,pivot_pos,rail_speed_setpoint")
    assert found["commands"] == {}
    assert "controlled by 0" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "kind", "unit"),
    [
        ("trolley_speed_setpoint_mps", "asked velocity", "m/s"),
        ("speed_cmd_mmps", "asked velocity", "mm/s"),
        ("wheel_radps", "velocity", "rad/s"),
        ("gx_dps", "velocity", "deg/s"),
        ("trolley_speed_cmd", "asked velocity", ""),
        ("desired.velocities[0]", "asked velocity", ""),
        ("desired.accelerations[0]", "other", ""),
    ],
)
def test_what_names_of_velocities_say(name: str, kind: str, unit: str) -> None:
    words = read_name("", name, "")
    assert (words.kind, words.unit) == (kind, unit)
