"""CSV to MCAP and back."""

from pathlib import Path

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.__main__ import main
from dr_lab.cli.compose import compose
from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.recorders.mcap import JointStates, write_mcap
from dr_lab.sources.csv_files import CsvSource
from dr_lab.trajectory import Log, MeasurementSet, Signal

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


@pytest.fixture
def contract() -> DataContract:
    return instantiate(compose("compare", []).measurements.contract)


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


def test_a_clock_that_begins_before_0_is_recorded_and_read_back_equal(tmp_path: Path, contract: DataContract) -> None:
    time = np.linspace(-0.5, 0.5, 51)
    joint = Signal("elbow.position", "rad", time, np.sin(time))
    command = Signal("motor", "V", time - 0.001, np.cos(time))
    log = Log("a", {joint.name: joint}, {command.name: command})
    (named,) = CsvSource(MeasurementSet("bench", (log,), (), {}, {}), "/j", "/command", "/s").logs(0)
    assert named.metadata["shift"] == "0.501000000 s"
    write_mcap(tmp_path / "a.mcap", named.topics, {}, named.metadata)
    read = read_log(
        tmp_path / "a.mcap",
        {joint.name: {"topic": "/j", "field": "position[elbow]", "unit": "rad", "clock": "header"}},
        {command.name: {"topic": "/command/motor", "field": "data[0]", "unit": "V"}},
        contract,
    )
    for before, after in ((joint, read.outputs[joint.name]), (command, read.commands[command.name])):
        np.testing.assert_array_equal(after.value, before.value)
        np.testing.assert_allclose(after.time - 0.501, before.time, rtol=0, atol=2e-9)


def test_a_recorded_log_from_0_on_keeps_its_times() -> None:
    (log,) = source(joint=Signal("a.position", "rad", np.array([0.1, 0.2]), np.zeros(2))).logs(0)
    assert "shift" not in log.metadata
    np.testing.assert_array_equal(log.topics[0].log_time, [0.1, 0.2])


def test_stretches_whose_names_differ_by_their_brackets_alone_get_files_of_their_own() -> None:
    joint = Signal("a.position", "rad", np.array([0.1, 0.2]), np.zeros(2))
    names = ("log_1[:3]", "log_1[3:]", "log_1_3_2", "run/a b")
    logs = tuple(Log(name, {joint.name: joint}, {}) for name in names)
    recorded = list(CsvSource(MeasurementSet("bench", logs[:2], logs[2:], {}, {}), "/j", "/c", "/s").logs(0))
    assert [log.name for log in recorded] == ["log_1_3", "log_1_3_2", "log_1_3_2_2", "run_a_b"]
    assert [log.metadata["log"] for log in recorded] == list(names)
