"""Commands in columns whose names say nothing, beside positions that are known by theirs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from played_logs import played, write_log

from dr_lab.__main__ import main

CART = """<mujoco model="it"><option timestep="0.001" integrator="RK4"/><worldbody><body name="cart">
  <joint name="rail" type="slide" axis="1 0 0" damping="0.5"/><geom type="box" size="0.1 0.05 0.05" mass="2"/>
  <body name="pole"><joint name="pivot" axis="0 1 0" damping="0.001"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.01" mass="0.3"/></body>
</body></worldbody><actuator><motor name="motor" joint="rail" gear="1"/></actuator></mujoco>"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("it.xml").write_text(CART)


def logs(header: str, *, mjcf: str = CART, sign: float = 1.0, turned: bool = False) -> list[str]:
    """Tables of time, rail, pivot, command, and where the header has more the pivot's velocity."""
    paths = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        levels = rng.uniform(-6.0, 6.0, 40)
        time, place, control = played(mjcf, [0.0, 0.3 * (seed + 1)], 4.0, lambda t, u=levels: [u[int(t / 0.1)]], seed)
        if turned:  # noise that no force makes
            place = rng.normal(size=place.shape).cumsum(0)
        columns = [time, place, sign * control, np.gradient(place[:, 1], time)][: 3 + (header.count(",") > 3)]
        paths.append(write_log(str(seed), header, *columns))
    return paths


def proposed(paths: list[str]) -> dict[str, Any]:
    assert main(["init", "it.xml", *paths]) == 0
    return yaml.safe_load(Path("mine/measurements/it.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("header", ["t,x,theta,ia", "t,x,theta,c9,c8"])
def test_a_column_that_explains_the_motion_is_the_command_whatever_it_is_called(header: str) -> None:
    found = proposed(logs(header, sign=-1.0))
    name = header.split(",")[3]
    assert found["commands"] == {"motor": {"column": name, "unit": "N", "sign": -1}}
    assert found["outputs"] == {
        "rail.position": {"column": "x", "unit": "m"},
        "pivot.position": {"column": "theta", "unit": "rad"},
    }


def test_a_refusal_says_what_was_tried_and_how_to_name_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["init", "it.xml", *logs("t,x,theta,ia,theta_dot", turned=True)]) == 2
    told = capsys.readouterr().err
    assert "No reading of x, theta moves as rail, pivot do with ia as command: the best leaves" in told
    assert "Not read: theta_dot." in told
    assert "commands after the actuators (motor_command)" in told


def test_a_prefix_of_a_unit_is_believed_where_friction_bends_the_gain() -> None:
    """2.5 N/A, of which the robot's owner documents 4: the motion alone says 0.6 mA."""
    mjcf = CART.replace('gear="1"', 'gear="2.5"')
    Path("it.xml").write_text(CART.replace('gear="1"', 'gear="4"'))
    found = proposed(logs("t,x,theta,i_cmd_mA", mjcf=mjcf, sign=1e3))
    assert found["commands"] == {"motor": {"column": "i_cmd_mA", "unit": "mA"}}
    told = Path("mine/measurements/it.yaml").read_text(encoding="utf-8")
    assert "its scale of 0.001 is that of mA, as its name says; the motion alone says 0.00062" in told


@pytest.mark.parametrize(("name", "unit"), [("current_A", "A"), ("current", "1")])
def test_a_current_of_a_geared_motor_is_no_force(name: str, unit: str) -> None:
    """2.5 N/A."""
    mjcf = CART.replace('gear="1"', 'gear="2.5"')
    Path("it.xml").write_text(mjcf)
    found = proposed(logs(f"t,x,theta,{name}", mjcf=mjcf))
    assert found["commands"] == {"motor": {"column": name, "unit": unit}}
    assert "1 of ctrl is 2.5 N\n" in Path("mine/measurements/it.yaml").read_text(encoding="utf-8")
