"""Recorded models: plain MuJoCo moves the same, effects act, and the logs read back."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from mcap.reader import make_reader

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.experiment import readings
from dr_lab.errors import ConfigError, DrLabError, ModelError, UnknownNameError
from dr_lab.physics.model import from_spec
from dr_lab.sources.model import ModelSource
from dr_lab.trajectory import Array, MeasurementSet, Signal
from dr_lab.workflows.record import record

CONF = Path(__file__).parents[3] / "conf"
MOTOR = "peaks={motor:6}"
EXACT = "plant/instruments=exact"
ON_STEPS = [
    f"plant.instruments.{key}=0"
    for key in ("sample_jitter", "command_jitter", "actuation_latency", "transport_latency")
]
VALVE = """<mujoco>
  <option gravity="0 0 0"/>
  <worldbody><body><joint name="stem" type="%s" axis="0 0 1"/><geom size="0.1" mass="100"/></body></worldbody>
  <actuator><motor name="valve" joint="stem" ctrllimited="true" ctrlrange="2 8"/></actuator>
</mujoco>"""


@cache
def source(*overrides: str, model: str = "furuta") -> ModelSource:
    short = ["source=model", f"model={model}", "duration=1.0", "shares=[1.0,0.8,0.6]"]
    return instantiate(compose("record", [*short, *overrides]).source, _convert_="all")


def valve(joint: str) -> ModelSource:
    return replace(source(MOTOR), model=from_spec("valve", mujoco.MjSpec.from_string(VALVE % joint), {}), peaks=None)


def logs(folder: Path, recorded: ModelSource, seed: int = 3) -> MeasurementSet:
    """Written to MCAP, then read by the configuration that lies beside them."""
    record(recorded, str(folder), seed, folder)
    return instantiate(compose("compare", ["measurements=recorded"], folder).measurements, _convert_="all")


def positions(measured: MeasurementSet) -> Array:
    """Readings of the first log's joints, shape (n, k)."""
    return np.stack([signal.value for signal in measured.fit[0].outputs.values()], axis=1)


def log_start(path: Path) -> float:
    """Log time of the first message in s, which readers count from."""
    with path.open("rb") as file:
        return next(m.log_time for _, _, m in make_reader(file).iter_messages()) * 1e-9


def test_plain_mujoco_moves_the_same(tmp_path: Path) -> None:
    measured = logs(tmp_path, source(MOTOR, EXACT, *ON_STEPS))
    commands, readings = measured.fit[0].commands["motor"].value, positions(measured)
    model = mujoco.MjModel.from_xml_path(str(CONF / "model/furuta.xml"))
    data, path = mujoco.MjData(model), []
    for step in range(len(readings)):
        data.ctrl[0] = commands[max(step // 2 - 1, 0)]  # commands every 4 ms from 4 ms on, steps of 2 ms
        mujoco.mj_step(model, data)
        path.append(data.qpos.copy())
    np.testing.assert_allclose(readings, path, rtol=0, atol=1e-12)
    assert np.ptp(readings, axis=0).min() > 0.3


@pytest.mark.parametrize(
    ("name", "override"),
    [
        ("furuta", MOTOR),
        pytest.param("cartpole", MOTOR, marks=pytest.mark.slow),
        pytest.param("emps", "peaks={force:50}", marks=pytest.mark.slow),
        ("multiarm", "start={arm1:1.2}"),
    ],
)
def test_log_replays_in_its_own_model(tmp_path: Path, name: str, override: str) -> None:
    """With jitter and latencies: times are true to a nanosecond."""
    recorded = source(override, EXACT, model=name)
    log, model = logs(tmp_path, recorded).fit[1], recorded.model
    zero = log_start(tmp_path / "log_2.mcap")
    commands = {n: Signal(n, "", s.time + zero, s.value) for n, s in log.commands.items()}
    start = np.array([1.2]) if name == "multiarm" else model.nominal().qpos0
    for channel, signal in log.outputs.items():
        joint, time = channel.removesuffix(".position"), signal.time + zero
        again = readings(model, model.space.nominal, start, commands, [f"{joint}.position"], time)[f"{joint}.position"]
        np.testing.assert_allclose(signal.value, again[:, 0], rtol=0, atol=1e-9)


def test_an_effect_acts_as_the_parameter_it_adds_to(tmp_path: Path) -> None:
    """Viscous friction of 1 mN·m·s/rad is as much more damping."""
    effect = source(MOTOR, EXACT, "context={viscous_friction@arm.coefficient:0.001}")
    damping = source(MOTOR, EXACT, "context={arm.damping:0.0011}")
    plain = positions(logs(tmp_path / "plain", source(MOTOR, EXACT)))
    with_effect = positions(logs(tmp_path / "effect", effect))
    np.testing.assert_allclose(with_effect, positions(logs(tmp_path / "damping", damping)), rtol=0, atol=1e-12)
    assert np.abs(with_effect - plain).max() > 0.1


def test_a_sensor_that_is_late_shows_the_past(tmp_path: Path) -> None:
    late = source(MOTOR, EXACT, *ON_STEPS, "context={sensor_time_offset@pole.offset:0.01}")
    plain = positions(logs(tmp_path / "plain", source(MOTOR, EXACT, *ON_STEPS)))
    shifted = positions(logs(tmp_path / "late", late))
    np.testing.assert_allclose(shifted[5:, 1], plain[:-5, 1], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(shifted[:, 0], plain[:, 0])


def test_the_truth_is_written_down(tmp_path: Path) -> None:
    logs(
        tmp_path, source(MOTOR, "context={pole.mass:0.03,spring@arm.stiffness:0.004,coulomb_friction@pole.torque:1e-4}")
    )
    truth = yaml.safe_load((tmp_path / "truth.yaml").read_text(encoding="utf-8"))
    assert truth["effects"] == ["spring@arm", "coulomb_friction@pole"]
    assert truth["parameters"] == {
        "arm.mass": 0.095,
        "pole.mass": 0.03,
        "arm.damping": 1e-4,
        "pole.damping": 5e-5,
        "spring@arm.stiffness": 0.004,
        "spring@arm.reference": 0.0,
        "coulomb_friction@pole.torque": 1e-4,
    }
    assert truth["seed"] == 3


def test_a_seed_gives_the_same_logs_again(tmp_path: Path) -> None:
    for folder, seed in (("a", 3), ("b", 3), ("c", 4)):
        logs(tmp_path / folder, source(MOTOR), seed)
    first, again, other = ((tmp_path / f / "log_1.mcap").read_bytes() for f in "abc")
    assert first == again != other


@pytest.mark.parametrize(("joint", "count"), [("hinge", 2 * np.pi / 2048), ("slide", 0.02 / 2048)])
def test_encoders_count(tmp_path: Path, joint: str, count: float) -> None:
    counts = positions(logs(tmp_path, valve(joint))) / count
    np.testing.assert_allclose(counts, counts.round(), rtol=0, atol=1e-6)
    assert len(np.unique(counts.round())) > 20


def test_instruments_disturb_measure_and_log_as_on_a_bench(tmp_path: Path) -> None:
    def recorded(instruments: str, *overrides: str) -> MeasurementSet:
        chosen = source(MOTOR, *ON_STEPS, f"plant/instruments={instruments}", *overrides)
        return logs(tmp_path / instruments, chosen)

    true, seen = recorded("exact").fit[0], recorded("tachometers").fit[0]
    positions_of = [name for name in true.outputs if name.endswith(".position")]
    assert sorted(seen.outputs) == sorted(["arm.velocity", "pole.velocity", *positions_of])
    for name in positions_of:
        noise = seen.outputs[name].value - true.outputs[name].value
        assert noise.std() == pytest.approx(2e-4, rel=0.15)
    speed = seen.outputs["arm.velocity"]
    assert speed.unit == "rad/s"
    turned = np.gradient(true.outputs["arm.position"].value, true.outputs["arm.position"].time)
    assert (speed.value - turned)[5:-5].std() == pytest.approx(0.02, rel=0.3)
    assert len(recorded("sparse").fit[0].commands["motor"]) == pytest.approx(len(true.commands["motor"]) / 5, abs=1)


def test_commands_fill_the_range_about_its_middle(tmp_path: Path) -> None:
    measured = logs(tmp_path, valve("hinge"))
    for log, share in zip((*measured.fit, *measured.held_out), (1.0, 0.8, 0.6), strict=True):
        assert np.abs(log.commands["valve"].value - 5.0).max() == pytest.approx(3.0 * share)


@pytest.mark.parametrize(
    ("error", "text", "overrides"),
    [
        (ConfigError, "peaks={motor:NUMBER}", []),
        (ConfigError, "share for each log", [MOTOR, "shares=[]"]),
        (ConfigError, "source.duration is inf; expected a number below inf", [MOTOR, "duration=inf"]),
        (ConfigError, "source.duration is nan; expected a number above 0", [MOTOR, "duration=nan"]),
        (ConfigError, "source.travel is 0; expected a number above 0", [MOTOR, "source.travel=0.0"]),
        (ConfigError, "shares: 1 is nan; expected a finite number", [MOTOR, "shares=[1.0,nan]"]),
        (ConfigError, "peaks: motor is inf; expected a finite number", ["peaks={motor:inf}"]),
        (ConfigError, "start: arm is nan; expected a finite number", [MOTOR, "start={arm:nan}"]),
        (ConfigError, "arm.mass is 95 kg; expected a value within its bounds", [MOTOR, "context={arm.mass:95}"]),
        (ConfigError, "Widen them: model.parameters.arm.mass.low=", [MOTOR, "context={arm.mass:0.01}"]),
        (UnknownNameError, "Did you mean 'arm.mass'", [MOTOR, "context={arm.mas:0.1}"]),
        (UnknownNameError, "Did you mean 'spring'", [MOTOR, "context={sprin@arm.stiffness:0.1}"]),
        (UnknownNameError, "site for spring 'leg'", [MOTOR, "context={spring@leg.stiffness:0.1}"]),
        (UnknownNameError, "Did you mean 'spring@arm.stiffness'", [MOTOR, "context={spring@arm.stifness:0.1}"]),
        (
            ConfigError,
            "context has coulomb_friction@arm.torque -0.1, expected at least 0, where the effect is absent",
            [MOTOR, "context={coulomb_friction@arm.torque:-0.1}"],
        ),
        (UnknownNameError, "There is no actuator 'moter'", ["peaks={moter:6}"]),
        (UnknownNameError, "There is no joint 'leg'", [MOTOR, "start={leg:1}"]),
    ],
)
def test_mistakes_are_named(error: type[DrLabError], text: str, overrides: list[str]) -> None:
    with pytest.raises(InstantiationException) as raised:
        source(*overrides)
    assert isinstance(raised.value.__cause__, error)
    assert text in str(raised.value.__cause__)


def test_a_machine_that_diverges_is_said(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="diverges"):
        logs(tmp_path, source("peaks={motor:1e9}", "shares=[1.0]"))


def test_model_without_joints() -> None:
    still = from_spec(
        "still", mujoco.MjSpec.from_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"), {}
    )
    with pytest.raises(ModelError, match="has none"):
        replace(source(MOTOR), model=still, peaks=None)
