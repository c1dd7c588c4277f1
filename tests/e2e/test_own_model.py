"""A model of one's own, on which some effects of the catalogue cannot act."""

import json
import re
from pathlib import Path

import pytest

from dr_lab.__main__ import main

XML = """<mujoco model="gate">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="leaf">
    <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
    <joint name="hinge" axis="0 1 0" springdamper="0.6 0.5"/>
  </body></worldbody>
  <actuator><motor name="drive" joint="hinge" ctrllimited="true" ctrlrange="-1 1" delay="0.01" nsample="6"/></actuator>
</mujoco>"""
YAML = """_target_: dr_lab.physics.model.load
name: gate
mjcf: ${conf:model/gate.xml}
parameters:
  leaf.mass: {target: body.leaf.mass, unit: kg, low: 0.3, high: 0.8}
"""
LOGS = ("duration=2", "shares=[1,0.8,0.9]", "context={leaf.mass:0.6,sensor_time_offset@hinge.offset:0.01}")
OWN = ("--config-dir", "mine", "model=gate")
EFFECTS = "effect=[actuator_delay,viscous_friction,constant_offset,sensor_time_offset]"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the model and its logs."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "mine" / "model").mkdir(parents=True)
    (folder / "mine" / "model" / "gate.xml").write_text(XML)
    (folder / "mine" / "model" / "gate.yaml").write_text(YAML)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["record", "source=model", *OWN, *LOGS, "output=mine"]) == 0
    return folder


@pytest.fixture
def mine(recorded: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
    """What a command needs to use the model and its logs."""
    monkeypatch.chdir(recorded)
    return (*OWN, "measurements=recorded", "windows.seconds=4.8")


@pytest.mark.slow
def test_what_cannot_act_is_left_out_and_said(mine: tuple[str, ...]) -> None:
    assert main(["diagnose", *mine, EFFECTS, "hydra.run.dir=run"]) == 0
    report = json.loads(Path("run/report.json").read_text(encoding="utf-8"))
    assert report["verdict"] == "named"
    assert [row["effect"] for row in report["ranking"]] == ["sensor_time_offset"]
    delay, passive = (note["message"] for note in report["notes"] if note["kind"] == "not_tried")
    assert re.match(r"Not tried: actuator_delay@drive\. Actuator 'drive' already keeps \d+ commands\.", delay)
    assert passive.startswith(
        "Not tried: viscous_friction@hinge, constant_offset@hinge. Joint 'hinge' has springdamper"
    )


@pytest.mark.slow
def test_adding_it_is_refused_at_once(mine: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["add", *mine, "effect=actuator_delay", "effect.actuator=drive"]) == 2
    assert "Take its delay out of the MJCF" in capsys.readouterr().err
