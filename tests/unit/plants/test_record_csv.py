"""CSV to MCAP and back."""

from pathlib import Path

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.__main__ import main
from dr_lab.cli.compose import compose
from dr_lab.errors import DataError
from dr_lab.recorders.mcap import JointStates
from dr_lab.trajectory import Log, MeasurementSet, Signal
from dr_lab.workflows.record_csv import CsvSource

MEASUREMENTS = """
defaults:
  - /data_contract@contract: default
  - _self_
_target_: dr_lab.measurements.read.read
name: bench
logs: [{logs}]
fit: ["swing[0:0.5]"]
held_out: ["swing[0.6:]"]
time: {{column: t_ms, unit: ms}}
outputs:
  elbow.position: {{column: q_deg, unit: deg}}
  elbow.velocity: {{column: dq, unit: rad/s}}
  sensor.imu: {{column: [ax, ay], unit: m/s^2}}
commands:
  motor: {{column: u, unit: V}}
"""


def test_a_table_becomes_ros2_messages_in_si(tmp_path: Path) -> None:
    time = np.arange(0.0, 1.0, 0.01)
    table = np.stack([1e3 * time, 57.0 * np.sin(3 * time), 3 * np.cos(3 * time), time, -time, np.sign(time - 0.5)], 1)
    np.savetxt(tmp_path / "swing.csv", table, delimiter=",", header="t_ms,q_deg,dq,ax,ay,u", comments="", fmt="%.12g")
    group = tmp_path / "conf" / "measurements"
    group.mkdir(parents=True)
    (group / "bench.yaml").write_text(MEASUREMENTS.format(logs=tmp_path / "swing.csv"))
    arguments = ["source=csv", "measurements=bench", f"output={tmp_path / 'mcap'}", f"outputs={tmp_path / 'outputs'}"]
    assert main(["record", "--config-dir", str(tmp_path / "conf"), *arguments]) == 0
    assert sorted(p.name for p in (tmp_path / "mcap").iterdir()) == ["swing_0.6.mcap", "swing_0_0.5.mcap"]

    settings = compose("compare", ["measurements=bench"], config_dir=tmp_path / "conf").measurements
    original: MeasurementSet = instantiate(settings, _convert_="all")
    joint = {"topic": "/joint_states", "clock": "header"}
    settings.merge_with(
        OmegaConf.create({"logs": [str(tmp_path / "mcap" / "*.mcap")], "fit": ["swing_0_0.5"], "held_out": []})
    )
    settings.outputs = {
        "elbow.position": {**joint, "field": "position[elbow]", "unit": "rad"},
        "elbow.velocity": {**joint, "field": "velocity[elbow]", "unit": "rad/s"},
        "sensor.imu": {"topic": "/sensor/imu", "field": ["data[0]", "data[1]"], "unit": "m/s^2"},
    }
    settings.commands = {"motor": {"topic": "/command/motor", "field": "data[0]", "unit": "V"}}
    read: MeasurementSet = instantiate(settings, _convert_="all")
    before, after = original.fit[0], read.fit[0]
    for name in ("elbow.position", "elbow.velocity", "sensor.imu"):
        np.testing.assert_array_equal(after.outputs[name].value, before.outputs[name].value)
        np.testing.assert_allclose(after.outputs[name].time, before.outputs[name].time, rtol=0, atol=2e-9)
    np.testing.assert_array_equal(after.commands["motor"].value, before.commands["motor"].value)


def source(**outputs: Signal) -> CsvSource:
    named = {signal.name: signal for signal in outputs.values()}
    log = Log("a", named, {})
    return CsvSource(MeasurementSet("bench", (log,), (), {}, {}), "/joint_states", "/command", "/sensor")


def test_joints_sampled_at_different_times_share_messages_with_gaps() -> None:
    first = Signal("a.position", "rad", np.array([0.0, 0.2]), np.array([1.0, 2.0]))
    second = Signal("b.position", "rad", np.array([0.1, 0.2]), np.array([3.0, 4.0]))
    (log,) = source(first=first, second=second).logs(0)
    (states,) = log.topics
    assert isinstance(states, JointStates)
    np.testing.assert_array_equal(states.log_time, [0.0, 0.1, 0.2])
    np.testing.assert_array_equal(states.position, [[1.0, np.nan], [np.nan, 3.0], [2.0, 4.0]])


def test_a_velocity_without_its_position_is_refused() -> None:
    speed = Signal("a.velocity", "rad/s", np.array([0.0, 0.2]), np.array([1.0, 2.0]))
    with pytest.raises(DataError, match=r"a\.velocity"):
        list(source(speed=speed).logs(0))
