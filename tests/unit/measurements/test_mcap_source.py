"""MCAP files written by other libraries and by dr_lab, whole and damaged."""

import sys
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer
from mcap_ros2.writer import Writer as Ros2Writer

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.mcap import McapSource
from dr_lab.measurements.signal_map import channel_map
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap
from dr_lab.ros2 import FLOAT64 as FLOAT64_TYPE
from dr_lab.ros2 import encode_floats
from dr_lab.trajectory import Array

RULE = "=" * 80
TIME = f"{RULE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
HEADER = f"{RULE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{TIME}"
VECTOR = f"{RULE}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
IMU = (
    "std_msgs/Header header\ngeometry_msgs/Vector3 angular_velocity\nfloat64[9] covariance\nfloat32 temperature\n"
    f"uint16 status\nbool valid\n{HEADER}{VECTOR}"
)
JOINT_STATE = (
    f"std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n{HEADER}"
)
FLOAT64 = "float64 data\n"
SECOND = 1_000_000_000


def header(time_ns: int) -> dict[str, Any]:
    return {"stamp": {"sec": time_ns // SECOND, "nanosec": time_ns % SECOND}, "frame_id": "base"}


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """Five messages of three types, of a robot whose clock is 20 s behind, by a writer that is not ours."""
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as file:
        writer = Ros2Writer(file)
        imu = writer.register_msgdef("pkg/msg/Imu", IMU)
        states = writer.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        number = writer.register_msgdef("std_msgs/msg/Float64", FLOAT64)
        for k in range(5):
            stamp = 1_700_000_000 * SECOND + k * SECOND // 2
            log = stamp + 20 * SECOND + 1000
            rate = {"x": 0.1 * k, "y": 0.2 * k, "z": 0.3 * k}
            message = {"header": header(stamp), "angular_velocity": rate, "covariance": list(np.arange(9.0) + k)}
            message |= {"temperature": 20.5, "status": 7, "valid": k > 2}
            writer.write_message("/imu", imu, message, log_time=log, publish_time=log - 500)
            # Two drivers share the topic, one of them names the joints in another order and reports fewer.
            names, position = (["arm", "pole"], [k, 10.0 * k]) if k % 2 == 0 else (["pole"], [10.0 * k])
            message = {"header": header(stamp), "name": names, "position": position, "velocity": [], "effort": []}
            writer.write_message("/joint_states", states, message, log_time=log)
            writer.write_message("/u", number, {"data": -1.5 * k}, log_time=log)
        writer.finish()
    return path


def values(path: Path, topic: str, field: object) -> Array:
    return McapSource(path).samples(channel_map("sensor.x", {"topic": topic, "field": field, "unit": "1"}, "")).value


@pytest.mark.parametrize(
    ("topic", "field", "expected"),
    [
        ("/u", "data", -1.5 * np.arange(5)),
        ("/imu", "angular_velocity.z", 0.3 * np.arange(5)),
        ("/imu", "covariance[4]", 4.0 + np.arange(5)),
        ("/imu", "temperature", np.full(5, 20.5)),
        ("/imu", "status", np.full(5, 7.0)),
        ("/imu", "valid", [0.0, 0.0, 0.0, 1.0, 1.0]),
        ("/imu", "header.stamp.nanosec", [0.0, 5e8, 0.0, 5e8, 0.0]),
        ("/imu", {"angular_velocity.x": 2.0, "angular_velocity.y": -1.0}, np.zeros(5)),
        ("/imu", "covariance", np.arange(9.0) + np.arange(5)[:, None]),
        ("/imu", ["angular_velocity.x", "angular_velocity.z"], np.outer(np.arange(5), [0.1, 0.3])),
        ("/joint_states", "position[pole]", 10.0 * np.arange(5)),
        ("/joint_states", "position[arm]", [0.0, 2.0, 4.0]),
        ("/joint_states", "position[1]", [0.0, 20.0, 40.0]),
    ],
)
def test_any_numeric_field_by_path(foreign: Path, topic: str, field: object, expected: Array) -> None:
    np.testing.assert_allclose(values(foreign, topic, field), expected, atol=1e-6)


def test_all_three_clocks_are_given_to_the_nanosecond(foreign: Path) -> None:
    source = McapSource(foreign)
    samples = source.samples(channel_map("sensor.x", {"topic": "/imu", "field": "temperature", "unit": "1"}, ""))
    half_seconds = 0.5 * np.arange(5)
    np.testing.assert_allclose(samples.stamps["log"].elapsed, half_seconds, atol=1e-10)
    np.testing.assert_allclose(samples.stamps["publish"].elapsed, half_seconds - 500e-9, atol=1e-10)
    np.testing.assert_allclose(samples.stamps["header"].elapsed, half_seconds, atol=1e-10)
    assert samples.stamps["header"].zero == pytest.approx(-20.000001, abs=1e-9)
    number = source.samples(channel_map("u", {"topic": "/u", "field": "data", "unit": "V"}, ""))
    assert "header" not in number.stamps


def test_messages_without_the_entry_are_counted(foreign: Path) -> None:
    entry = {"topic": "/joint_states", "field": "position[arm]", "unit": "rad"}
    samples = McapSource(foreign).samples(channel_map("arm.position", entry, ""))
    assert samples.missing == 2
    np.testing.assert_allclose(samples.stamps["log"].elapsed, [0.0, 1.0, 2.0])


def test_labels_of_a_float_array_name_its_entries(tmp_path: Path) -> None:
    data = np.arange(6.0).reshape(3, 2)
    write_mcap(tmp_path / "a.mcap", [FloatArrays("/command", ("left", "right"), np.arange(3.0), data)], {}, {})
    np.testing.assert_array_equal(values(tmp_path / "a.mcap", "/command", "data[right]"), data[:, 1])
    with pytest.raises(UnknownNameError, match=r"no entry 'rigth'.*Did you mean 'right'\?"):
        values(tmp_path / "a.mcap", "/command", "data[rigth]")


@pytest.mark.parametrize(
    ("topic", "field", "error", "message"),
    [
        (
            "/joint_state",
            "position[arm]",
            UnknownNameError,
            r"no topic '/joint_state' .*Available: /imu, /joint_states, /u",
        ),
        (
            "/joint_states",
            "position[amr]",
            UnknownNameError,
            r"no joint 'amr' .*Did you mean 'arm'\? Available: arm, pole",
        ),
        ("/joint_states", "positoin[arm]", UnknownNameError, r"no field 'positoin' .*Did you mean 'position'\?"),
        ("/joint_states", "position[2]", DataError, r"no message has an entry \[2\]; their lists have up to 2"),
        ("/joint_states", "velocity[arm]", DataError, r"no message has an entry \[arm\]; their lists have up to 0"),
        ("/joint_states", "position", DataError, r"a list whose length changes"),
        ("/imu", "angular_velocity", DataError, r"is a group; add one of its fields: x, y, z"),
        ("/imu", "header.frame_id", DataError, r"holds string, not numbers"),
        ("/imu", "temperature.x", DataError, r"has no field 'x'"),
        ("/imu", "temperature[0]", DataError, r"is not a list"),
        ("/imu", "[0]", DataError, r"is not a field path"),
        ("/imu", "", DataError, r"is not a field path"),
        ("/imu", "covariance[", DataError, r"is not a field path"),
    ],
)
def test_wrong_names_say_what_there_is(
    foreign: Path, topic: str, field: str, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        values(foreign, topic, field or "..")


def one_topic(count: int) -> JointStates:
    time = np.linspace(1.7e9, 1.7e9 + 0.002 * count, count, endpoint=False)
    return JointStates("/joint_states", ("arm",), time, time, np.random.default_rng(0).normal(size=(count, 1)))


def test_a_cut_file_gives_what_is_complete_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    states = one_topic(5000)
    write_mcap(path, [states], {}, {})
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 2 // 3])
    source = McapSource(path)
    entry = {"topic": "/joint_states", "field": "position[arm]", "unit": "rad"}
    recovered = source.samples(channel_map("arm.position", entry, "")).value
    assert 2000 < len(recovered) < 3400
    np.testing.assert_array_equal(recovered, states.position[: len(recovered), 0])
    (note,) = source.notes
    assert (note.kind, note.count) == ("cut", len(recovered))
    assert f"{len(recovered)} complete messages were recovered" in note.message


def test_a_whole_file_has_no_note(foreign: Path) -> None:
    assert McapSource(foreign).notes == ()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", r"is empty \(0 bytes\)"),
        (b"time,q\n0,1\n", "is not an MCAP file"),
        (b"\x89MCAP0\r\n" + bytes(40), "damaged and nothing in it could be recovered"),
    ],
)
def test_files_that_are_no_mcap(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(DataError, match=message):
        McapSource(path)


@pytest.mark.parametrize(
    ("damaged", "reason"),
    [
        (lambda whole: whole.index(b"dr_lab\0\0\0\0"), "1 of 2 chunks with /joint_states are not as they were written"),
        (lambda whole: len(whole) // 4, "1 of 2 chunks with /joint_states are not as they were written"),
        (lambda whole: whole.rindex(b"sensor_msgs/msg/JointState") + 60, "MCAP error: Invalid schema"),
    ],
)
def test_damaged_records_are_one_clear_error(tmp_path: Path, damaged: Callable[[bytes], int], reason: str) -> None:
    path = tmp_path / "a.mcap"
    write_mcap(path, [one_topic(3000)], {}, {})
    whole = path.read_bytes()
    at = damaged(whole)
    path.write_bytes(whole[:at] + bytes(byte ^ 0x5A for byte in whole[at : at + 40]) + whole[at + 40 :])
    with pytest.raises(DataError, match=rf"a\.mcap is damaged \({reason}.*\)\. Copy it again") as raised:
        values(path, "/joint_states", "position[arm]")
    assert len(str(raised.value).splitlines()) == 1


def test_a_file_cut_before_its_first_message_says_so(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    write_mcap(path, [one_topic(3000)], {}, {})
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(DataError, match="is cut before its first message was complete"):
        McapSource(path)


@pytest.mark.parametrize("topics", [[], [FloatArrays("/u", ("a",), np.empty(0), np.empty((0, 1)))]])
def test_an_mcap_without_messages(tmp_path: Path, topics: list[FloatArrays]) -> None:
    write_mcap(tmp_path / "a.mcap", topics, {}, {})
    with pytest.raises(DataError, match="holds no messages"):
        McapSource(tmp_path / "a.mcap")


def test_other_encodings_are_named(tmp_path: Path) -> None:
    with (tmp_path / "json.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/q", "json", writer.register_schema("q", "jsonschema", b"{}"))
        writer.add_message(channel, log_time=1, publish_time=1, data=b'{"q": 1}')
        writer.finish()
    with pytest.raises(DataError, match="its encoding is json with schema jsonschema; expected cdr"):
        values(tmp_path / "json.mcap", "/q", "q")


def test_messages_that_cannot_be_decoded_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        schema = writer.register_schema(FLOAT64_TYPE.name, "ros2msg", FLOAT64_TYPE.text.encode())
        channel = writer.register_channel("/u", "cdr", schema)
        for k in range(50):
            data = encode_floats(np.array([float(k)]))[0].tobytes()[: 6 if k % 10 == 3 else None]
            writer.add_message(channel, log_time=k, publish_time=k, data=data)
        writer.finish()
    source = McapSource(path)
    read = source.samples(channel_map("u", {"topic": "/u", "field": "data", "unit": "V"}, "")).value
    np.testing.assert_array_equal(read, [k for k in range(50) if k % 10 != 3])
    (note,) = source.notes
    assert (note.kind, note.count) == ("undecoded", 5)
    assert note.message == "5 of 50 messages of /u could not be decoded and were left out."


def test_overlapping_chunks_come_in_the_order_of_log_time(tmp_path: Path) -> None:
    with (tmp_path / "a.mcap").open("wb") as file:
        writer = Writer(file, chunk_size=64)
        writer.start(profile="ros2")
        schema = writer.register_schema(FLOAT64_TYPE.name, "ros2msg", FLOAT64_TYPE.text.encode())
        channel = writer.register_channel("/u", "cdr", schema)
        for k in np.random.default_rng(0).permutation(200).tolist():
            data = encode_floats(np.array([float(k)]))[0].tobytes()
            writer.add_message(channel, log_time=k, publish_time=k, data=data)
        writer.finish()
    np.testing.assert_array_equal(values(tmp_path / "a.mcap", "/u", "data"), np.arange(200.0))


def test_more_messages_take_no_more_python(tmp_path: Path) -> None:
    names = tuple(f"joint_{i}" for i in range(12))
    calls = []
    for count in (2_000, 2_000, 20_000):  # the first reads the table of units
        stamps, position = np.arange(count) / 500, np.random.default_rng(0).normal(size=(count, 12))
        path = tmp_path / f"{len(calls)}.mcap"
        write_mcap(path, [JointStates("/joint_states", names, stamps, stamps, position)], {}, {})
        events: Counter[str] = Counter()
        sys.setprofile(lambda frame, event, argument, events=events: events.update([event]))
        try:
            read = values(path, "/joint_states", "position[joint_7]")
        finally:
            sys.setprofile(None)
        np.testing.assert_array_equal(read, position[:, 7])
        calls.append(events["call"] + events["c_call"])
    assert 0 < calls[2] - calls[1] < 18_000 / 2


def test_a_column_entry_is_refused(foreign: Path) -> None:
    entries: Mapping[str, Any] = {"column": "q", "unit": "rad"}
    with pytest.raises(DataError, match=r"is an MCAP file. Write topic: NAME and field: PATH"):
        McapSource(foreign).samples(channel_map("arm.position", entries, ""))
