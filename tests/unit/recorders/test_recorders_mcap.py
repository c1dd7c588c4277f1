"""Written MCAP files, read back by two libraries that dr_lab did not write."""

from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from rerun.chunk import McapReader

from dr_lab.errors import DataError, DrLabError
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap

NAMES = ("arm", "pole_ä")


def joint_states(count: int, start: float = 1.7e9) -> JointStates:
    rng = np.random.default_rng(0)
    time = np.linspace(start, start + 0.002 * count, count, endpoint=False)
    return JointStates("/joint_states", NAMES, time - 20.0, time, rng.normal(size=(count, 2)))


def messages(path: Path, topic: str) -> list[dict]:
    """All messages of a topic through Rerun's reflection decoder."""
    rows: list[dict] = []
    for chunk in McapReader(path, decoders=["ros2_reflection"]).stream():
        batch = chunk.to_record_batch()
        column = next((name for name in batch.schema.names if name.endswith(":message")), None)
        if str(chunk.entity_path) == topic and column:
            rows += [row[0] for row in batch.column(column).to_pylist()]
    return rows


@pytest.mark.parametrize("fields", [(), ("velocity",), ("effort",), ("velocity", "effort")])
def test_joint_states_survive_the_round_trip(tmp_path: Path, fields: tuple[str, ...]) -> None:
    states = joint_states(50)
    values = np.random.default_rng(1).normal(size=(2, 50, 2))
    extra = dict(zip(fields, values, strict=False))
    states = JointStates(states.topic, NAMES, states.stamp, states.log_time, states.position, **extra)
    write_mcap(tmp_path / "a.mcap", [states], {}, {})
    rows = messages(tmp_path / "a.mcap", "/joint_states")
    assert [row["name"] for row in rows] == [list(NAMES)] * 50
    np.testing.assert_array_equal([row["position"] for row in rows], states.position)
    for name in ("velocity", "effort"):
        expected = extra.get(name)
        np.testing.assert_array_equal([row[name] for row in rows], np.empty((50, 0)) if expected is None else expected)
    stamp = [row["header"]["stamp"]["sec"] + row["header"]["stamp"]["nanosec"] * 1e-9 for row in rows]
    np.testing.assert_allclose(stamp, states.stamp, rtol=0, atol=5e-7)


def test_stamps_before_the_epoch_and_fractions_keep_their_nanoseconds(tmp_path: Path) -> None:
    stamp = np.array([-1.25, 0.0, 0.000000001, 3.999999999])
    write_mcap(tmp_path / "a.mcap", [JointStates("/j", ("a",), stamp, np.arange(4.0), np.zeros((4, 1)))], {}, {})
    stamps = [row["header"]["stamp"] for row in messages(tmp_path / "a.mcap", "/j")]
    assert [(s["sec"], s["nanosec"]) for s in stamps] == [(-2, 750_000_000), (0, 0), (0, 1), (3, 999_999_999)]


def test_float_arrays_carry_their_labels(tmp_path: Path) -> None:
    data = np.arange(6.0).reshape(3, 2)
    write_mcap(tmp_path / "a.mcap", [FloatArrays("/command", ("left", "right"), np.arange(3.0), data)], {}, {})
    rows = messages(tmp_path / "a.mcap", "/command")
    np.testing.assert_array_equal([row["data"] for row in rows], data)
    assert rows[0]["layout"]["dim"] == [{"label": "left,right", "size": 2, "stride": 2}]


def test_topics_are_merged_by_log_time_with_their_own_sequence_numbers(tmp_path: Path) -> None:
    command = FloatArrays("/command", ("motor",), 1.7e9 + np.array([0.001, 0.003]), np.zeros((2, 1)), np.arange(2.0))
    write_mcap(tmp_path / "a.mcap", [joint_states(3), command], {}, {})
    with (tmp_path / "a.mcap").open("rb") as file:
        found = [
            (c.topic, m.sequence, m.publish_time) for _, c, m in make_reader(file).iter_messages(log_time_order=False)
        ]
    assert [(topic, sequence) for topic, sequence, _ in found] == [
        ("/joint_states", 0), ("/command", 0), ("/joint_states", 1), ("/command", 1), ("/joint_states", 2),
    ]  # fmt: skip
    assert [time for topic, _, time in found if topic == "/command"] == [0, 1_000_000_000]


def test_pieces_of_one_topic_share_a_channel_and_its_sequence(tmp_path: Path) -> None:
    first, second = joint_states(3), joint_states(2, start=1.8e9)
    commands = [
        FloatArrays("/command", ("u",), states.log_time, np.zeros((len(states.log_time), 1)))
        for states in (first, second)
    ]
    write_mcap(tmp_path / "a.mcap", [first, second, *commands], {}, {})
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        sequence = [message.sequence for _, channel, message in reader.iter_messages(topics=["/joint_states"])]
    assert summary is not None
    assert sorted(channel.topic for channel in summary.channels.values()) == ["/command", "/joint_states"]
    assert len(summary.schemas) == 2
    assert sequence == [0, 1, 2, 3, 4]


def test_container_has_ros2_profile_small_zstd_chunks_attachments_and_metadata(tmp_path: Path) -> None:
    write_mcap(tmp_path / "a.mcap", [joint_states(5000)], {"model.xml": b"<mujoco/>"}, {"run": "7"})
    with (tmp_path / "a.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        chunks = reader.get_summary().chunk_indexes  # pyright: ignore[reportOptionalMemberAccess]
        assert {chunk.compression for chunk in chunks} == {"zstd"}
        assert len(chunks) > 2
        assert all(64 * 1024 <= chunk.uncompressed_size <= 256 * 1024 for chunk in chunks[:-1])
        assert [(a.name, a.data, a.media_type) for a in reader.iter_attachments()] == [
            ("model.xml", b"<mujoco/>", "application/xml")
        ]
        assert [(m.name, m.metadata) for m in reader.iter_metadata()] == [("dr_lab", {"run": "7"})]


def test_rerun_plots_both_types_as_scalars_with_joint_names(tmp_path: Path) -> None:
    command = FloatArrays("/command", ("motor",), np.arange(3.0), np.ones((3, 1)))
    write_mcap(tmp_path / "a.mcap", [joint_states(3), command], {}, {})
    found = {}
    for chunk in McapReader(tmp_path / "a.mcap").stream():
        batch = chunk.to_record_batch()
        if "Scalars:scalars" in batch.schema.names:
            found[str(chunk.entity_path)] = batch
    assert {"/joint_states/position", "/command"} <= set(found)
    assert found["/joint_states/position"].column("SeriesLines:names")[0].as_py() == list(NAMES)


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        (FloatArrays("/c", ("a", "b"), np.arange(3.0), np.zeros((3, 1))), r"'/c': data .*\(3, 2\).*got \(3, 1\)"),
        (FloatArrays("/c", ("a",), np.array([0.0, np.nan]), np.zeros((2, 1))), "log_time must be 2 finite times"),
        (JointStates("/j", ("a",), np.arange(2.0), np.arange(3.0), np.zeros((3, 1))), "stamp must be 3 finite times"),
        (
            FloatArrays("/c", ("a",), np.array([0.0, 1e10]), np.zeros((2, 1))),
            r"log_time lies up to 1e\+10 s .*Cut such",
        ),
        (JointStates("/j", ("a",), np.array([3e9]), np.zeros(1), np.zeros((1, 1))), r"stamp lies up to 3e\+09 s"),
        (FloatArrays("/c", ("a",), np.array([-0.5, 0.0]), np.zeros((2, 1))), r"'/c': log_time begins at -0\.5 s"),
    ],
)
def test_wrong_shapes_are_named(tmp_path: Path, topic: JointStates | FloatArrays, message: str) -> None:
    with pytest.raises(DataError, match=message):
        write_mcap(tmp_path / "a.mcap", [topic], {}, {})
    assert list(tmp_path.iterdir()) == []


def test_an_unwritable_place_is_one_clear_error_and_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(DrLabError, match="Cannot write"):
        write_mcap(tmp_path / "file" / "a.mcap", [joint_states(3)], {}, {})
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_an_interrupted_write_keeps_the_previous_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"previous")

    def interrupt(*_args: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("dr_lab.recorders.mcap._write_messages", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_mcap(path, [joint_states(3)], {}, {})
    assert path.read_bytes() == b"previous"
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.mcap"]
