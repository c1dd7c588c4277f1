"""rosbag2 folders and .db3 files give the samples of the MCAP file with the same messages."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from bags import write_bag
from rosbags.rosbag2 import StoragePlugin

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.inventory import messages_of
from dr_lab.measurements.log import read_log
from dr_lab.measurements.read import read
from dr_lab.recorders.mcap import JointStates, write_mcap

TIME = np.linspace(0.0, 2.0, 400, endpoint=False)
ANGLE = np.sin(3 * TIME)
ARM = {"arm.position": {"topic": "/joint_states", "field": "position[arm]", "unit": "rad"}}


@pytest.mark.parametrize("clock", ["log", "header", "publish"])
@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_a_bag_folder_reads_as_the_mcap_file_does(
    tmp_path: Path, contract: DataContract, storage: StoragePlugin, clock: str
) -> None:
    write_bag(tmp_path / "run_1.2", ("arm",), TIME, ANGLE[:, None], storage=storage)
    write_mcap(tmp_path / "a.mcap", [JointStates("/joint_states", ("arm",), TIME, TIME, ANGLE[:, None])], {}, {})
    (log,) = read("bench", [str(tmp_path / "run_*")], ARM, contract, clock=clock).fit
    plain = read_log(tmp_path / "a.mcap", ARM, {}, contract, clock=clock)
    assert log.name == "run_1.2"
    found, expected = log.outputs["arm.position"], plain.outputs["arm.position"]
    np.testing.assert_array_equal(found.value, expected.value)
    np.testing.assert_allclose(found.time, expected.time, atol=1e-6)


def test_compressed_messages_and_a_file_without_its_folder_are_read(tmp_path: Path, contract: DataContract) -> None:
    packed = write_bag(tmp_path / "packed", ("arm",), TIME, ANGLE[:, None], compressed=True)
    np.testing.assert_array_equal(read_log(packed, ARM, {}, contract).outputs["arm.position"].value, ANGLE)
    plain = write_bag(tmp_path / "plain", ("arm",), TIME, ANGLE[:, None]) / "plain.db3"
    np.testing.assert_array_equal(read_log(plain, ARM, {}, contract).outputs["arm.position"].value, ANGLE)


def test_a_topic_of_an_unknown_type_is_left_out_and_said(tmp_path: Path, contract: DataContract) -> None:
    path = write_bag(tmp_path / "bag", ("arm",), TIME, ANGLE[:, None]) / "bag.db3"
    with sqlite3.connect(path) as database:
        database.execute("INSERT INTO topics VALUES (9, '/own', 'own_msgs/msg/State', 'cdr', '', '')")
        database.execute("INSERT INTO messages VALUES (1000, 9, 1, x'00')")
    database.close()
    (note,) = [n for n in read_log(path, ARM, {}, contract).notes if n.kind == "undefined"]
    assert note.message == "bag.db3: no definition of /own (own_msgs/msg/State); left out."


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.db3", b"no database", r"Cannot read .*a\.db3: .*not a database\. Expected what rosbag2 writes"),
        ("a.db3", b"", r"Cannot read .*a\.db3: .*missing tables"),
        ("bag/metadata.yaml", b"a: 1", r"Cannot read .*bag: .*rosbag2_bagfile_information.*ros2 bag reindex"),
    ],
)
def test_what_is_no_bag_is_refused(
    tmp_path: Path, contract: DataContract, name: str, content: bytes, message: str
) -> None:
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    with pytest.raises(DataError, match=message):
        read_log(path if path.suffix == ".db3" else path.parent, ARM, {}, contract)


def test_pictures_are_not_taken_along(tmp_path: Path, contract: DataContract) -> None:
    path = write_bag(tmp_path / "bag", ("arm",), TIME, ANGLE[:, None]) / "bag.db3"
    with sqlite3.connect(path) as database:
        database.execute("INSERT INTO topics VALUES (9, '/camera', 'sensor_msgs/msg/Image', 'cdr', '', '')")
        database.execute("INSERT INTO messages VALUES (1000, 9, 1, x'00')")
    database.close()
    assert read_log(path, ARM, {}, contract).notes == ()
    assert {place.topic for place in messages_of(path)} == {"/joint_states"}
