"""From configuration to measurements: clocks, latencies, defects, splits, and every error a user meets first."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from csv_logs import ANGLE, TIME, Q, csv

from dr_lab.errors import ConfigError, DataError, UnknownNameError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.measurements.read import read
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap
from dr_lab.trajectory import Array

COUNT = 2 * np.pi / 2048
EPOCH = 1.7e9

OUTPUTS: dict[str, Any] = {
    "arm.position": {"topic": "/joint_states", "field": "position[arm]", "unit": "rad", "latency": 0.001},
    "pole.position": {"topic": "/joint_states", "field": "position[pole]", "unit": "rad", "latency": 0.001},
}
COMMANDS: dict[str, Any] = {
    "motor": {"topic": "/voltage", "field": "data[0]", "unit": "V", "clock": "log", "latency": 0.0015}
}


def motion(time: Array) -> Array:
    return np.stack([0.8 * np.sin(3 * time), 1.5 * np.cos(6 * time)], axis=1)


def record(path: Path, seed: int = 0, command_delay: float = 0.0) -> None:
    """A robot whose clock is 20 s behind and 40 ppm slow; joint states at 500 Hz, voltages at 250 Hz."""
    rng = np.random.default_rng(seed)
    true = np.linspace(0.0, 6.0, 3000, endpoint=False)
    position = COUNT * np.round((1 + 0.01 * seed) * motion(true) / COUNT)
    log_time = true + 0.001 + rng.exponential(0.3e-3, len(true))
    stamp = (true - 20.0) * (1 - 40e-6)
    sent = np.linspace(0.0, 6.0, 1500, endpoint=False)
    voltage = np.where(sent % 1.0 < 0.5, 2.0, -2.0)[:, None]
    topics = [
        JointStates("/joint_states", ("pole", "arm"), EPOCH + stamp, EPOCH + log_time, position[:, ::-1]),
        FloatArrays("/voltage", ("motor",), EPOCH + sent + 0.0015 + command_delay, voltage),
    ]
    write_mcap(path, topics, {}, {})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for k in range(3):
        record(tmp_path / f"log_{k}.mcap", seed=k)
    return tmp_path


def test_header_clock_is_mapped_and_latencies_subtracted(folder: Path, contract: DataContract) -> None:
    log = read_log(folder / "log_0.mcap", OUTPUTS, COMMANDS, contract, clock="header")
    arm, motor = log.outputs["arm.position"], log.commands["motor"]
    assert (len(arm), len(motor)) == (3000, 1500)
    # Both are on true time, up to the file's zero (its first log time).
    zero = motor.time[0]
    np.testing.assert_allclose(motor.time - zero, np.linspace(0.0, 6.0, 1500, endpoint=False), atol=1e-6)
    np.testing.assert_allclose(arm.time - zero, np.linspace(0.0, 6.0, 3000, endpoint=False), atol=10e-6)
    np.testing.assert_allclose(arm.value, motion(arm.time - zero)[:, 0], atol=0.51 * COUNT)
    fit = log.clocks["arm.position"]
    assert fit.clock == "header"
    assert fit.drift == pytest.approx(40e-6, abs=2e-6)
    assert fit.offset == pytest.approx(20.0 * (1 - 40e-6) + 0.001, abs=20e-6)
    assert 0.05e-3 < fit.jitter < 0.3e-3
    assert log.clocks["motor"].clock == "log"
    assert {note.kind for note in log.notes} <= {"reordered"}


def test_log_and_publish_clocks_are_taken_as_they_are(folder: Path, contract: DataContract) -> None:
    entry = dict(OUTPUTS["arm.position"]) | {"latency": 0.0}
    for clock in ("log", "publish"):
        log = read_log(folder / "log_0.mcap", {"arm.position": entry}, {}, contract, clock=clock)
        assert log.outputs["arm.position"].time[0] == 0.0
        assert log.clocks["arm.position"] == dataclasses.replace(
            log.clocks["arm.position"], clock=clock, offset=0.0, drift=0.0, jitter=0.0
        )


def test_a_set_has_logs_noise_and_gaps(folder: Path, contract: DataContract) -> None:
    found = read(
        name="bench",
        logs=[str(folder / "*.mcap")],
        fit=["log_0", "log_2[1:3]"],
        held_out=["log_1"],
        clock="header",
        outputs=OUTPUTS,
        commands=COMMANDS,
        contract=contract,
    )
    assert ([log.name for log in found.fit], [log.name for log in found.held_out]) == (
        ["log_0", "log_2[1:3]"],
        ["log_1"],
    )
    assert found.noise["arm.position"].std == pytest.approx(COUNT / np.sqrt(12), rel=0.1)
    assert (found.noise["pole.position"].unit, found.noise["pole.position"].source) == ("rad", "estimated")
    assert found.gaps["arm.position"] == pytest.approx(5 * 0.002, rel=0.01)
    segment = found.fit[1]
    assert segment.outputs["arm.position"].time[0] == pytest.approx(1.0, abs=0.002)
    assert segment.outputs["arm.position"].time[-1] == pytest.approx(3.0, abs=0.002)
    # The command that is in force when the segment starts is kept.
    assert segment.commands["motor"].time[0] <= 1.0 < segment.commands["motor"].time[1]


def test_what_a_command_does_between_samples_is_kept_and_asked_of_commands_alone(
    folder: Path, contract: DataContract
) -> None:
    logs, line = [str(folder / "*.mcap")], {"between": "line"}
    sent = {name: dict(entry) | line for name, entry in COMMANDS.items()}
    assert read("bench", logs, OUTPUTS, contract, sent).fit[0].commands["motor"].between == "line"
    assert read("bench", logs, OUTPUTS, contract, COMMANDS).fit[0].commands["motor"].between == ""
    shown = {name: dict(entry) | line for name, entry in OUTPUTS.items()}
    with pytest.raises(ConfigError, match=r"between is for commands"):
        read("bench", logs, shown, contract, COMMANDS)


def test_given_noise_is_in_the_channels_unit(folder: Path, contract: DataContract) -> None:
    entry = dict(OUTPUTS["arm.position"]) | {"unit": "rad", "noise_std": 0.004}
    degrees = dict(OUTPUTS["pole.position"]) | {"unit": "deg", "scale": 180 / np.pi, "noise_std": 0.5}
    outputs = {"arm.position": entry, "pole.position": degrees}
    noise = read("bench", [str(folder / "log_0.mcap")], outputs, contract, clock="header").noise
    assert (noise["arm.position"].std, noise["arm.position"].source) == (0.004, "given")
    assert noise["pole.position"].std == pytest.approx(np.deg2rad(0.5))


def test_fit_null_takes_what_is_not_held_out(folder: Path, contract: DataContract) -> None:
    found = read("bench", [str(folder / "*.mcap")], OUTPUTS, contract, held_out=["log_1"], clock="header")
    assert [log.name for log in found.fit] == ["log_0", "log_2"]
    assert found.fit[0].commands == {}


def test_which_logs_were_loaded(folder: Path, contract: DataContract) -> None:
    logs = [str(folder / "*.mcap")]
    found = read("bench", logs, OUTPUTS, contract, held_out=["log_1"], clock="header", loaded=["log_[12]"])
    assert {log.name: log.loaded for log in (*found.fit, *found.held_out)} == {
        "log_0": False,
        "log_1": True,
        "log_2": True,
    }
    assert all(log.loaded for log in read("bench", logs, OUTPUTS, contract, clock="header").fit)
    with pytest.raises(UnknownNameError, match="log_3"):
        read("bench", logs, OUTPUTS, contract, clock="header", loaded=["log_3"])


def test_no_overlap_names_both_spans(tmp_path: Path, contract: DataContract) -> None:
    record(tmp_path / "a.mcap", command_delay=100.0)
    with pytest.raises(
        DataError, match=r"'motor' \(.* to 10\d.* s\) and 'arm.position' .* do not overlap .* another clock"
    ):
        read_log(tmp_path / "a.mcap", OUTPUTS, COMMANDS, contract, clock="header")


def test_clocks_that_are_not_there(folder: Path, tmp_path: Path, contract: DataContract) -> None:
    command = {"motor": dict(COMMANDS["motor"]) | {"clock": "header"}}
    with pytest.raises(
        DataError, match=r"/voltage data\[0\] of log_0.mcap\) has no header stamps; it has: log, publish"
    ):
        read_log(folder / "log_0.mcap", OUTPUTS, command, contract, clock="header")
    with pytest.raises(DataError, match="has no header stamps; it has: column"):
        read_log(csv(tmp_path / "a.csv", time=TIME, q=ANGLE), Q, {}, contract, clock="header")
    time = np.linspace(0.0, 1.0, 500)
    states = JointStates("/joint_states", ("arm",), np.zeros(500), time, np.sin(time)[:, None])
    write_mcap(tmp_path / "zero.mcap", [states], {}, {})
    with pytest.raises(
        DataError, match=r"all header .* equal, nobody set them\. Choose another clock: log or publish\."
    ):
        read_log(tmp_path / "zero.mcap", {"arm.position": OUTPUTS["arm.position"]}, {}, contract, clock="header")


def stamped(path: Path, stamp: Array, log_time: Array) -> Path:
    write_mcap(path, [JointStates("/joint_states", ("arm",), stamp, log_time, np.sin(log_time)[:, None])], {}, {})
    return path


@pytest.mark.parametrize("unset", [slice(1), slice(50), slice(400, 401), slice(None, None, 3)])
def test_the_log_time_stands_for_header_stamps_of_0(tmp_path: Path, contract: DataContract, unset: slice) -> None:
    true = np.linspace(0.0, 2.0, 1000, endpoint=False)
    stamp = EPOCH - 20.0 + true
    stamp[unset] = 0.0
    late = np.random.default_rng(0).exponential(0.3e-3, 1000)
    path = stamped(tmp_path / "a.mcap", stamp, EPOCH + true + late)
    log = read_log(path, {"arm.position": OUTPUTS["arm.position"] | {"latency": 0.0}}, {}, contract, clock="header")
    (note,) = [note for note in log.notes if note.kind == "unset_stamps"]
    assert note.count == len(true[unset])
    assert f"{note.count} of 1000 header stamps are 0, nobody set them; the log time stands for them" in note.message
    arm = log.outputs["arm.position"]
    named = {time: index for index, time in enumerate(np.sin(EPOCH + true + late).tolist())}
    places = [named[value] for value in arm.value.tolist()]
    expected = np.where(stamp == 0.0, true + late, true)[places]
    assert len(arm) > 990
    np.testing.assert_allclose(arm.time - expected, (arm.time - expected).mean(), atol=20e-6)
    assert log.clocks["arm.position"].offset == pytest.approx(20.0, abs=20e-6)


def test_a_simulators_clock_may_begin_at_0(tmp_path: Path, contract: DataContract) -> None:
    time = np.linspace(0.0, 2.0, 1000, endpoint=False)
    path = stamped(tmp_path / "a.mcap", time, EPOCH + time + 0.01)
    log = read_log(path, {"arm.position": OUTPUTS["arm.position"]}, {}, contract, clock="header")
    assert (log.notes, len(log.outputs["arm.position"])) == ((), 1000)


@pytest.mark.parametrize(
    ("settings", "error", "message"),
    [
        ({"logs": ["{}/log_7.mcap"]}, DataError, r"no file '.*log_7\.mcap'; folder .* holds log_0\.mcap, log_1\.mcap"),
        ({"logs": ["{}/*.csv"]}, DataError, r"No file matches '.*\*\.csv'; folder .* holds log_0\.mcap"),
        ({"logs": ["{}/missing/a/*.mcap"]}, DataError, r"No file matches .*; folder .* holds log_0"),
        (
            {"logs": ["$DR_LAB_NOWHERE/*.csv"]},
            DataError,
            r"variable DR_LAB_NOWHERE is not set.*export DR_LAB_NOWHERE=FOLDER",
        ),
        (
            {"fit": ["log_9"]},
            UnknownNameError,
            r"no log 'log_9' in logs\. Did you mean 'log_\d'\? Available: log_0, log_1",
        ),
        (
            {"fit": ["log_0"], "held_out": ["log_0[2:3]"]},
            ConfigError,
            r"'log_0' \(fit\) and 'log_0\[2:3\]' \(held_out\) share",
        ),
        ({"fit": [], "held_out": []}, ConfigError, r"Neither fit nor held_out names a log"),
        ({"fit": ["log_0[a:b]"]}, ConfigError, r"is not name\[a:b\]"),
        ({"fit": ["log_0[3:2]"]}, ConfigError, r"ends before it begins"),
        ({"outputs": {}}, ConfigError, r"'bench' name no outputs"),
        ({"time": {"colunm": "t"}}, ConfigError, r"time has no key 'colunm'; it has column, unit, scale, start, stop"),
    ],
)
def test_wrong_files_and_splits_are_explained(
    folder: Path, contract: DataContract, settings: dict[str, Any], error: type[Exception], message: str
) -> None:
    usual: dict[str, Any] = {"logs": ["{}/*.mcap"], "outputs": OUTPUTS, "clock": "header"}
    usual |= settings
    usual["logs"] = [name.format(folder) for name in usual["logs"]]
    with pytest.raises(error, match=message):
        read(name="bench", contract=contract, **usual)


def test_segments_of_one_file_may_be_fitted_and_held_out(folder: Path, contract: DataContract) -> None:
    logs = [str(folder / "log_0.mcap")]
    found = read("bench", logs, OUTPUTS, contract, fit=["log_0[:3]"], held_out=["log_0[3:]"], clock="header")
    fitted, scored = (part[0].outputs["arm.position"].time for part in (found.fit, found.held_out))
    assert fitted[-1] <= 3.0 <= scored[0]
    assert len(fitted) + len(scored) == 3000


def test_two_files_of_one_stem_and_unknown_suffixes(folder: Path, contract: DataContract) -> None:
    (folder / "sub").mkdir()
    record(folder / "sub" / "log_0.mcap")
    with pytest.raises(DataError, match="have the same stem"):
        read("bench", [str(folder / "**" / "*.mcap")], OUTPUTS, contract)
    (folder / "log.bag").write_text("x")
    with pytest.raises(ConfigError, match=r"log\.bag: a log is an \.mcap or \.db3 file"):
        read("bench", [str(folder / "log.bag")], OUTPUTS, contract)
    with pytest.raises(DataError, match="There is no file"):
        read_log(folder / "nothing.mcap", OUTPUTS, {}, contract)
