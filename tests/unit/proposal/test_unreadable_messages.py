"""Fields and topics of messages that cannot be read: init reads the others, and says which it does not."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
from bags import START
from own_robot import JOINTS, MJCF, Motion
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

from dr_lab.__main__ import main

STORE = get_typestore(Stores.ROS2_HUMBLE)
JOINT_STATE, TEMPERATURE = "sensor_msgs/msg/JointState", "sensor_msgs/msg/Temperature"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.xml").write_text(MJCF)


def header(second: float) -> Any:  # noqa: ANN401  (rosbags makes the types)
    stamp = divmod(START + round(1e9 * second), 10**9)
    return STORE.types["std_msgs/msg/Header"](STORE.types["builtin_interfaces/msg/Time"](*stamp), "")


def joint_states(motion: Motion, *, velocities: int = 0, rate: float = 1.0) -> list[tuple[float, object]]:
    """Messages with the time at which they were logged; the velocities of the first joints alone."""
    made = STORE.types[JOINT_STATE]
    rows = zip(motion.time.tolist(), motion.position, motion.velocity, motion.torque, strict=True)
    return [
        (time, made(header(rate * time), [*JOINTS], position, velocity[:velocities], torque))
        for time, position, velocity, torque in rows
    ]


def temperatures(stamped: Sequence[float], logged: Sequence[float]) -> list[tuple[float, object]]:
    made = STORE.types[TEMPERATURE]
    return [(at, made(header(stamp), 20.0 + at, 0.0)) for stamp, at in zip(stamped, logged, strict=True)]


def found(capsys: pytest.CaptureFixture[str], **topics: list[tuple[float, object]]) -> tuple[dict[str, Any], str]:
    """The measurements of a bag, and what was told."""
    with Writer(Path("run"), version=8) as writer:
        for topic, messages in topics.items():
            kind = JOINT_STATE if topic.startswith("joint") else TEMPERATURE
            connection = writer.add_connection(f"/{topic}", kind, typestore=STORE)
            for at, message in messages:
                data = STORE.serialize_cdr(message, kind)
                writer.write(connection, START + round(1e9 * at), data)
    assert main(["init", "two.xml", "run"]) == 0
    return yaml.safe_load(Path("mine/measurements/two.yaml").read_text(encoding="utf-8")), capsys.readouterr().out


def read_by(measurements: dict[str, Any]) -> list[str]:
    every = [*measurements["outputs"].values(), *measurements["commands"].values()]
    return [f"{each['topic']} {each['field']} {each.get('clock', measurements['clock'])}" for each in every]


ALL = [f"/joint_states {kind}[{joint}] header" for kind in ("position", "effort") for joint in JOINTS]


def test_few_messages_of_one_stamp_keep_nothing_from_being_read(capsys: pytest.CaptureFixture[str]) -> None:
    """As a topic that holds its last message sends it, to everyone who comes."""
    measurements, told = found(capsys, joint_states=joint_states(Motion(0)), motor=temperatures([0, 0], [0.1, 2]))
    assert read_by(measurements) == ALL
    assert "/motor" not in told


def test_the_log_time_stands_for_stamps_of_simulated_time(capsys: pytest.CaptureFixture[str]) -> None:
    motion = Motion(0)
    measurements, told = found(
        capsys,
        joint_states=joint_states(motion),
        motor=temperatures((0.3 * motion.time).tolist(), motion.time.tolist()),
    )
    assert read_by(measurements) == ALL
    assert "/motor: the log time stands for its header stamps. The header stamps of /motor run 0.3 times as" in told


def test_what_is_read_by_the_log_time_has_that_clock(capsys: pytest.CaptureFixture[str]) -> None:
    measurements, _ = found(capsys, joint_states=joint_states(Motion(0), rate=0.3))
    assert read_by(measurements) == [place.replace(" header", " log") for place in ALL]


def test_a_list_shorter_than_its_names_is_read_as_far_as_it_goes(capsys: pytest.CaptureFixture[str]) -> None:
    measurements, told = found(capsys, joint_states=joint_states(Motion(0), velocities=1))
    assert read_by(measurements) == ALL
    assert "/joint_states velocity[elbow] is not read: topic '/joint_states'" in told
    assert "sensor." not in told
