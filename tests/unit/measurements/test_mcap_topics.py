"""MCAP topics of several publishers, and lists where one number is expected."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.writer import Writer

from dr_lab.errors import DataError, UnknownNameError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.measurements.mcap import McapSource
from dr_lab.measurements.signal_map import channel_map
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap
from dr_lab.ros2 import FLOAT64, FLOAT64_MULTI_ARRAY, MessageType, encode_float_arrays, encode_floats

TIME = np.linspace(0.0, 2.0, 200, endpoint=False)
PERIOD = 10_000_000  # ns


def publishers(path: Path, second: MessageType) -> McapSource:
    """Two publishers of one topic who take turns, each in a channel of its own; the numbers count the messages."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2")
        for turn, kind in enumerate((FLOAT64, second)):
            schema = writer.register_schema(kind.name, "ros2msg", kind.text.encode())
            channel = writer.register_channel("/u", "cdr", schema, metadata={"publisher": str(turn)})
            for k in range(turn, 200, 2):
                value = np.array([float(k)])
                rows = encode_floats(value) if kind is FLOAT64 else encode_float_arrays(("u",), value[:, None])
                writer.add_message(channel, log_time=k * PERIOD, publish_time=k * PERIOD, data=rows[0].tobytes())
        writer.finish()
    return McapSource(path)


def test_publishers_of_one_topic_are_read_together(tmp_path: Path) -> None:
    source = publishers(tmp_path / "a.mcap", FLOAT64)
    samples = source.samples(channel_map("u", {"topic": "/u", "field": "data", "unit": "V"}, ""))
    np.testing.assert_array_equal(samples.value, np.arange(200.0))
    assert source.notes == ()


def test_a_topic_of_single_numbers_holds_no_rows(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"Float64\) of a\.mcap holds no arrays; expected std_msgs/msg/Float64Multi"):
        publishers(tmp_path / "a.mcap", FLOAT64).rows("/u")


def test_publishers_of_different_types_are_refused(tmp_path: Path) -> None:
    source = publishers(tmp_path / "a.mcap", FLOAT64_MULTI_ARRAY)
    with pytest.raises(DataError, match=r"'/u' of a\.mcap holds messages of several types \(.*Float64, .*Float64Multi"):
        source.samples(channel_map("u", {"topic": "/u", "field": "data", "unit": "V"}, ""))


@pytest.fixture
def two(tmp_path: Path) -> Path:
    """Joint states of two joints, and commands of one actuator whose label nobody wrote."""
    position = np.stack([np.sin(TIME), np.cos(TIME)], axis=1)
    states = JointStates("/joint_states", ("a", "b"), TIME, TIME, position)
    write_mcap(tmp_path / "two.mcap", [states, FloatArrays("/u", ("",), TIME, position[:, :1])], {}, {})
    return tmp_path / "two.mcap"


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (["position[a]", "position"], r"puts together lists .* position\[a\] 1, position 2\. Take one entry"),
        (["position", "position"], r"puts together lists .* position 2\. Take"),
        ({"position[a]": 1, "position": 1}, r"puts together lists .* position\[a\] 1, position 2\. Take"),
        ("position", r"position of two\.mcap\) has 2 numbers a sample; .* Take one entry, e\.g\. \[0\]"),
    ],
)
def test_lists_where_a_number_is_expected_are_refused(
    two: Path, contract: DataContract, field: object, message: str
) -> None:
    entry: Mapping[str, Any] = {"topic": "/joint_states", "field": field, "unit": "rad"}
    with pytest.raises(DataError, match=message):
        read_log(two, {"a.position": entry}, {}, contract)


def test_a_sensor_called_position_may_have_several_numbers(two: Path, contract: DataContract) -> None:
    place = {"sensor.position": {"topic": "/joint_states", "field": "position", "unit": "m"}}
    log = read_log(two, place, {}, contract)
    assert log.outputs["sensor.position"].value.shape == (len(TIME), 2)


def test_a_list_of_one_number_is_that_number(two: Path, contract: DataContract) -> None:
    angle = {"a.position": {"topic": "/joint_states", "field": "position[a]", "unit": "rad"}}
    log = read_log(two, angle, {"u": {"topic": "/u", "field": "data", "unit": "V"}}, contract)
    np.testing.assert_array_equal(log.commands["u"].value, np.sin(TIME))


def test_a_label_that_nobody_wrote_names_nothing(two: Path) -> None:
    with pytest.raises(UnknownNameError, match=r"no entry 'u' .* Available: none\."):
        McapSource(two).samples(channel_map("u", {"topic": "/u", "field": "data[u]", "unit": "V"}, ""))
