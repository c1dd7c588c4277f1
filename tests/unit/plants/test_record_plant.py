"""Logs of the plant on disk: read back, small, reproducible, and with the truth out of reach."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from hydra.utils import instantiate
from mcap.reader import make_reader

from dr_lab.__main__ import main
from dr_lab.cli.compose import compose
from dr_lab.trajectory import MeasurementSet

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "examples" / "furuta"
SHORT = ["plant.duration=1.0", "plant.peaks=[6.0,5.0]", "seed=3"]


def read_back(folder: Path, names: list[str], machine: str = "furuta") -> MeasurementSet:
    settings = compose("compare", [f"measurements={machine}"]).measurements
    settings.logs, settings.fit, settings.held_out = [f"{folder}/*.mcap"], names, []
    return instantiate(settings, _convert_="all")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("logs")
    outputs = tmp_path_factory.mktemp("outputs")
    assert main(["record", "plant/hidden=furuta/spring_arm", *SHORT, f"output={folder}", f"outputs={outputs}"]) == 0
    return folder


def test_logs_are_ros2_recordings(recorded: Path) -> None:
    assert sorted(p.name for p in recorded.iterdir()) == ["log_1.mcap", "log_2.mcap", "truth.yaml"]
    with (recorded / "log_1.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        topics = {c.topic: s.name for s, c, _ in reader.iter_messages() if s}
    assert topics == {"/joint_states": "sensor_msgs/msg/JointState", "/motor_voltage": "std_msgs/msg/Float64MultiArray"}


def test_reader_recovers_readings_and_the_times_at_which_things_happened(recorded: Path) -> None:
    overrides = ["plant/hidden=furuta/spring_arm", "plant/instruments=exact", *SHORT]
    exact = list(instantiate(compose("record", overrides).plant, _convert_="all").recordings(3))
    for log, recording in zip(read_back(recorded, ["log_1", "log_2"]).fit, exact, strict=True):
        command = log.commands["motor"]
        zero = float(np.mean(recording.command_time - (command.time - 5e-4)))
        np.testing.assert_array_equal(command.value, recording.command[:, 0])
        np.testing.assert_allclose(command.time + zero, recording.command_time + 5e-4, rtol=0, atol=1e-6)
        for joint, name in enumerate(("arm.position", "pole.position")):
            signal = log.outputs[name]
            np.testing.assert_allclose(signal.value, recording.position[:, joint], rtol=0, atol=np.pi / 2048 + 1e-9)
            # The exact instruments' robot clock is the host's.
            np.testing.assert_allclose(signal.time + zero, recording.stamp, rtol=0, atol=1e-5)


def test_every_actuator_and_joint_is_read_back_under_its_name(tmp_path: Path) -> None:
    options = ["plant=double_pendulum", "plant.duration=0.3", "plant.peaks=[1.0]", "seed=3"]
    assert main(["record", *options, f"output={tmp_path}", f"outputs={tmp_path / 'outputs'}"]) == 0
    bench = instantiate(compose("record", [*options, "plant/instruments=exact"]).plant, _convert_="all")
    (log,), (recording,) = read_back(tmp_path, ["log_1"], "double_pendulum").fit, bench.recordings(3)
    for column, name in enumerate(("shoulder", "elbow")):
        np.testing.assert_array_equal(log.commands[name].value, recording.command[:, column])
        read = log.outputs[f"{name}.position"].value
        np.testing.assert_allclose(read, recording.position[:, column], rtol=0, atol=np.pi / 2048 + 1e-9)


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        ("plant.instruments.counts=0", "plant.instruments.counts is 0; expected at least 1"),
        ("plant.instruments.clock_drift=[6e-5,2e-5]", "expected [lowest, highest], lowest <= highest"),
        ("plant.instruments.clock_offset=[1.0]", "plant.instruments.clock_offset is [1.0]; expected 2 finite numbers"),
        ("plant.excitation.lowest=0", "plant.excitation.lowest is 0; expected a number above 0"),
        (
            "plant.excitation.hold=[0,0.5]",
            "plant.excitation.hold is [0, 0.5]; expected 2 finite numbers, each a number",
        ),
        ("plant.nominal.arm_mass=-1", "plant.nominal.arm_mass is -1; expected a number above 0"),
        ("plant.accuracy.longest_step=0", "plant.accuracy.longest_step is 0; expected a number above 0"),
        ("plant.duration=inf", "plant.duration is inf; expected a finite number"),
        ("plant.peaks=[nan]", "plant.peaks is [nan]; expected finite numbers"),
        ("plant=cartpole plant.travel.cart=0", "plant.travel: cart is 0 m; expected a number above 0"),
        ("plant/hidden=furuta/saturation plant.hidden.limit=-1", "plant.hidden.limit is -1; expected a number above 0"),
    ],
)
def test_numbers_that_no_bench_has_are_refused(
    overrides: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["record", *overrides.split(), f"outputs={tmp_path}"]) == 2
    assert said in capsys.readouterr().err


def test_the_truth_is_written_down(recorded: Path) -> None:
    truth = yaml.safe_load((recorded / "truth.yaml").read_text(encoding="utf-8"))
    assert truth["seed"] == 3
    assert truth["hidden"] == {"effect": "spring@arm", "parameters": {"stiffness": 3e-3, "rest": 0.0}}
    assert truth["parameters"]["arm.mass"] == pytest.approx(0.095, rel=0.15)
    assert set(truth["parameters"]) == {"arm.mass", "pole.mass", "arm.damping", "pole.damping"}


def test_only_recorders_the_benchmark_and_targets_know_the_truth() -> None:
    knowing = {"plants", "benchmark", "sources", "targets"}
    for path in (ROOT / "dr_lab").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        if not knowing & {*path.relative_to(ROOT).parts}:
            assert "truth.yaml" not in text, path
            assert "dr_lab.plants" not in text, path
    for path in (ROOT / "conf").rglob("*.yaml"):
        assert "truth.yaml" not in path.read_text(encoding="utf-8"), path


def test_the_logs_do_not_tell_what_is_hidden(recorded: Path) -> None:
    with (recorded / "log_1.mcap").open("rb") as file:
        reader = make_reader(file)
        assert [record.metadata for record in reader.iter_metadata()] == [{"source": "simulated machine"}]
        assert list(reader.iter_attachments()) == []


def test_examples_are_small() -> None:
    assert sum(p.stat().st_size for p in EXAMPLES.iterdir()) < 3_000_000
    assert len(list(EXAMPLES.glob("*.mcap"))) == 6


@pytest.mark.slow
def test_examples_are_what_the_experiment_records(tmp_path: Path) -> None:
    settings = ["record", "experiment=furuta_demo", f"output={tmp_path / 'logs'}", f"outputs={tmp_path / 'outputs'}"]
    assert main(settings) == 0
    names = sorted(path.stem for path in EXAMPLES.glob("*.mcap"))
    for kept, made in zip(*(read_back(folder, names).fit for folder in (EXAMPLES, tmp_path / "logs")), strict=True):
        # Processors differ in the last bit of a sine, which may turn a reading by one count.
        np.testing.assert_allclose(kept.commands["motor"].value, made.commands["motor"].value, rtol=0, atol=1e-12)
        for name, signal in kept.outputs.items():
            np.testing.assert_allclose(signal.time, made.outputs[name].time, rtol=0, atol=1e-6)
            turned = np.abs(signal.value - made.outputs[name].value)
            assert turned.max() < 1.01 * 2 * np.pi / 2048
            assert (turned > 0).mean() < 0.01
    assert (EXAMPLES / "truth.yaml").read_text() == (tmp_path / "logs" / "truth.yaml").read_text()
