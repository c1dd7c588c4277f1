"""What is easily misread: joints called by digits, units, turns behind a gear, unsigned clocks, commands that hold."""

import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from bags import write_bag
from csv_logs import ANGLE, TIME, Q, U, csv
from pyarrow import parquet

from dr_lab.errors import ConfigError, DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.field_path import extract
from dr_lab.measurements.log import read_log
from dr_lab.measurements.raw_log import TimeAxis
from dr_lab.measurements.read import read
from dr_lab.measurements.split import until
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap

Entry = dict[str, Any]


def test_joints_may_be_called_by_digits(tmp_path: Path, contract: DataContract) -> None:
    position = np.stack([ANGLE, ANGLE + 5.0], axis=1)
    write_mcap(tmp_path / "a.mcap", [JointStates("/joint_states", ("1", "2"), TIME, TIME, position)], {}, {})
    entry = {"topic": "/joint_states", "unit": "rad"}
    outputs = {"one.position": entry | {"field": "position[1]"}, "two.position": entry | {"field": "position[2]"}}
    found = read_log(tmp_path / "a.mcap", outputs, {}, contract).outputs
    np.testing.assert_array_equal(found["one.position"].value, ANGLE)
    np.testing.assert_array_equal(found["two.position"].value, ANGLE + 5.0)


def test_integers_of_more_digits_than_a_float_are_rounded() -> None:
    stamps = 1_700_000_000_000_000_001 + np.arange(3)
    messages = pa.StructArray.from_arrays([pa.array(stamps)], ["timestamp_ns"])
    np.testing.assert_allclose(extract(messages, "timestamp_ns", "topic /x").value, stamps.astype(float))


@pytest.mark.parametrize(
    ("channel", "unit", "message"),
    [
        (
            "q.position",
            "count",
            r"unit 'count' .*measured in rad, deg, m or mm.*Of counts give the angle or way of one",
        ),
        ("q.position", "1", r"unit '1' has dimension dimensionless"),
        ("q.velocity", "Hz", r"unit 'Hz' .*measured in rad/s, deg/s or m/s"),
        ("sensor.imu", "g", r"unit 'g' is the gram\. Write g_0 for an acceleration"),
    ],
)
def test_units_that_measure_something_else_are_refused(
    tmp_path: Path, contract: DataContract, channel: str, unit: str, message: str
) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, q=ANGLE)
    with pytest.raises(DataError, match=message):
        read_log(path, {channel: {"column": "q", "unit": unit}}, {}, contract)


def test_motors_turn_fast_in_turns_a_minute(tmp_path: Path, contract: DataContract) -> None:
    """2 500 a minute are 262 rad/s, which would be suspected to be degrees if they were given in radians."""
    path = csv(tmp_path / "a.csv", time=TIME, v=2500 * np.sin(TIME))
    entry: Entry = {"column": "v", "unit": "rpm"}
    found = read_log(path, {"q.velocity": entry}, {}, contract).outputs["q.velocity"]
    assert np.abs(found.value).max() == pytest.approx(2500 * 2 * np.pi / 60, rel=1e-3)
    with pytest.raises(DataError, match=r"There is no unit 'RPM' .*Did you mean 'rpm'\?"):
        read_log(path, {"q.velocity": entry | {"unit": "RPM"}}, {}, contract)
    with pytest.raises(DataError, match=r"turns at .*raise measurements\.contract\.speed_limit"):
        read_log(path, {"q.velocity": entry | {"unit": "rad/s", "scale": 0.105}}, {}, contract)


def test_standard_gravities_are_accelerations(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=TIME, a=np.sin(TIME))
    found = read_log(path, {"sensor.imu": {"column": "a", "unit": "g_0"}}, {}, contract).outputs["sensor.imu"]
    np.testing.assert_allclose(found.value, 9.80665 * np.sin(TIME), rtol=1e-7)


def test_a_motor_angle_is_unwrapped_behind_its_gear(tmp_path: Path, contract: DataContract) -> None:
    motor = 30 * TIME
    path = csv(tmp_path / "a.csv", time=TIME, q=np.mod(motor, 2 * np.pi))
    entry: Entry = {"column": "q", "unit": "rad", "scale": 0.1}
    log = read_log(path, {"q.position": entry | {"wrap": 0.2 * np.pi}}, {}, contract)
    np.testing.assert_allclose(log.outputs["q.position"].value, 0.1 * motor, atol=1e-6)
    kept = read_log(path, {"q.position": entry | {"wrap": True}}, {}, contract)
    (note,) = (each for each in kept.notes if each.kind == "wrap")
    assert "nothing jumps by a full turn" in note.message
    with pytest.raises(ConfigError, match="wrap is 'yes'; expected true for an angle"):
        read_log(path, {"q.position": entry | {"wrap": "yes"}}, {}, contract)


def test_stretches_of_a_log_count_the_same_turns(tmp_path: Path, contract: DataContract) -> None:
    """Behind a gear a turn of the motor is none of the joint: gravity would pull another way."""
    motor, lost = 30 * TIME, np.arange(len(TIME)) % 50 == 7
    shown = np.where(lost, np.nan, np.mod(motor, 2 * np.pi))
    path = csv(tmp_path / "a.csv", time=TIME, q=shown)
    entry: Entry = {"column": "q", "unit": "rad", "scale": 0.1, "wrap": 0.2 * np.pi}
    found = read("bench", [str(path)], {"q.position": entry}, contract, fit=["a[:1.5]"], held_out=["a[1.5:3]", "a[3:]"])
    parts = [log.outputs["q.position"] for log in (*found.fit, *found.held_out)]
    for part in parts:
        np.testing.assert_allclose(part.value, 3 * part.time, atol=1e-6)


@pytest.mark.parametrize("kind", [np.uint32, np.uint64, np.int64])
def test_unsigned_clocks_do_not_wrap_around(tmp_path: Path, contract: DataContract, kind: type) -> None:
    stamps = (1_000_000 + np.rint(1e6 * TIME)).astype(kind)
    stamps[[0, 1]] = stamps[[1, 0]]
    parquet.write_table(pa.table({"time": stamps, "q": ANGLE}), tmp_path / "a.parquet")
    time = read_log(tmp_path / "a.parquet", Q, {}, contract, time=TimeAxis(unit="us")).outputs["q.position"].time
    assert len(time) == len(TIME)
    np.testing.assert_allclose(np.diff(time), 0.002, atol=1e-9)


def test_a_clock_may_count_samples(tmp_path: Path, contract: DataContract) -> None:
    path = csv(tmp_path / "a.csv", time=np.arange(len(TIME)), q=ANGLE)
    axis: Entry = {"unit": 1, "scale": 0.002}
    (log,) = read("bench", [str(path)], Q, contract, time=axis).fit
    np.testing.assert_allclose(log.outputs["q.position"].time, TIME, atol=1e-9)


def test_a_tracker_that_lost_its_body_is_left_out(tmp_path: Path, contract: DataContract) -> None:
    half = 0.2 * np.sin(TIME)
    lost = np.arange(len(TIME)) % 40 == 5
    path = csv(
        tmp_path / "a.csv", time=TIME, w=np.where(lost, 0, np.cos(half)), x=np.where(lost, 0, np.sin(half)), y=0, z=0
    )
    log = read_log(path, {"sensor.pose": {"column": ["w", "x", "y", "z"], "unit": "1"}}, {}, contract)
    assert len(log.outputs["sensor.pose"].time) == len(TIME) - lost.sum()
    assert any("are all zeros, no orientation" in note.message for note in log.notes)


def test_position_and_velocity_need_no_common_time(tmp_path: Path, contract: DataContract) -> None:
    first, later = TIME < 2.0, TIME >= 2.0
    q, v = np.where(first, ANGLE, np.nan), np.where(later, -6 * np.sin(5 * TIME), np.nan)
    path = csv(tmp_path / "a.csv", time=TIME, q=q, v=v)
    outputs = Q | {"q.velocity": {"column": "v", "unit": "rad/s"}}
    found = read_log(path, outputs, {}, contract).outputs
    assert found["q.position"].time[-1] < found["q.velocity"].time[0]


@pytest.mark.parametrize("sparse", [False, True])
def test_a_command_of_before_the_start_holds(tmp_path: Path, contract: DataContract, sparse: bool) -> None:
    """Whichever way a stretch is taken, and also where most cells of the command are empty."""
    if sparse:
        sent = np.full(len(TIME), np.nan)
        sent[[0, 500, 1500]] = 0.0, 5.0, -5.0
        path, outputs, commands = csv(tmp_path / "a.csv", time=TIME, q=ANGLE, u=sent), Q, U
    else:
        states = JointStates("/joint_states", ("q",), TIME, TIME, ANGLE[:, None])
        sent = FloatArrays("/u", ("m",), np.array([0.0, 1.0, 3.0]), np.array([[0.0], [5.0], [-5.0]]))
        path = tmp_path / "a.mcap"
        write_mcap(path, [states, sent], {}, {})
        outputs = {"q.position": {"topic": "/joint_states", "field": "position[q]", "unit": "rad"}}
        commands = {"m": {"topic": "/u", "field": "data[0]", "unit": "V"}}
    (cut,) = read("bench", [str(path)], outputs, contract, commands, time={"start": 2.0}).fit
    (part,) = read("bench", [str(path)], outputs, contract, commands, fit=["a[2:]"]).fit
    for log in (cut, part):
        np.testing.assert_allclose(log.commands["m"].value, [5.0, -5.0])
        assert log.outputs["q.position"].time[0] >= 2.0 - 1e-9


def test_letters_of_other_alphabets_end_no_line(tmp_path: Path, contract: DataContract) -> None:
    rows = "\n".join(f"{t:.4f};{q:.6f}" for t, q in zip(TIME, ANGLE, strict=True))
    (tmp_path / "a.csv").write_text(f"czas;kąt\n{rows}\n", encoding="utf-8")
    outputs = {"q.position": {"column": "kąt", "unit": "rad"}}
    log = read_log(tmp_path / "a.csv", outputs, {}, contract, time=TimeAxis(column="czas"))
    assert len(log.outputs["q.position"].time) == len(TIME)


def test_variables_in_names_of_files_are_filled_in(
    tmp_path: Path, contract: DataContract, monkeypatch: pytest.MonkeyPatch
) -> None:
    csv(tmp_path / "a.csv", time=TIME, q=ANGLE)
    monkeypatch.setenv("MY_DATA", str(tmp_path))
    assert len(read("bench", ["${MY_DATA}/a.csv"], Q, contract).fit) == 1
    with pytest.raises(DataError, match="Environment variable MY_DATE is not set"):
        read("bench", ["${MY_DATE}/a.csv"], Q, contract)


def test_a_bag_of_nothing_but_unknown_types_says_so(tmp_path: Path, contract: DataContract) -> None:
    path = write_bag(tmp_path / "bag", ("arm",), TIME, ANGLE[:, None]) / "bag.db3"
    with sqlite3.connect(path) as database:
        database.execute("INSERT INTO topics VALUES (9, '/own', 'own_msgs/msg/State', 'cdr', '', '')")
        database.execute("INSERT INTO messages VALUES (9999, 9, 1, x'00')")
    asked = {"q.position": {"topic": "/own", "field": "q", "unit": "rad"}}
    with pytest.raises(
        DataError, match=r"'/own' of bag\.db3 cannot be read: no definition of /own .*Record with ROS 2"
    ):
        read_log(path, asked, {}, contract)
    with sqlite3.connect(path) as database:
        database.execute("DELETE FROM messages WHERE topic_id != 9")
        database.execute("DELETE FROM topics WHERE id != 9")
    database.close()
    with pytest.raises(DataError, match=r"no definition of /own \(own_msgs/msg/State\), and nothing else is in it"):
        read_log(path, asked, {}, contract)


def test_a_stretch_of_a_stretch_is_one_of_the_log() -> None:
    assert until("log_1", 3.2) == "log_1[:3.2]"
    assert until("log_1[1:10]", 3.2) == "log_1[1:3.2]"
