"""The real data sets through their shipped configurations; needs DR_LAB_DATA, the folder that holds them."""

import os
from pathlib import Path

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from hydra.errors import InstantiationException
from hydra.utils import instantiate

from dr_lab.errors import DataError
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.log import read_log
from dr_lab.measurements.raw_log import TimeAxis
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.trajectory import Array, MeasurementSet, Signal

CONF = Path(__file__).parents[3] / "conf"
DATA = os.environ.get("DR_LAB_DATA")

CUBE = ("position", "orientation")
real = pytest.mark.skipif(
    DATA is None, reason="DR_LAB_DATA is not set: export DR_LAB_DATA=FOLDER of the real data sets"
)


def load(name: str, *overrides: str) -> MeasurementSet:
    with initialize_config_dir(str(CONF), version_base=None):
        config = compose(overrides=[f"+measurements={name}", *overrides])
    return instantiate(config.measurements, _convert_="all")


@real
@pytest.mark.parametrize(
    ("name", "fit", "held_out", "channels", "std"),
    [
        ("dfki_c1", 4, 3, ["shoulder.position", "elbow.position"], 3.8e-4 / np.sqrt(12)),
        ("dfki_a0", 4, 3, ["shoulder.position", "elbow.position"], 3.8e-4 / np.sqrt(12)),
        ("dfki_simple_pendulum", 2, 2, ["pendulum.position", "pendulum.velocity"], 0.0029 / np.sqrt(12)),
        ("emps", 1, 1, ["axis.position"], 5e-8 / np.sqrt(12)),
        ("multiarm_single", 2, 4, ["arm1.position"], 2e-5),
        ("multiarm_double", 13, 17, ["arm1.position", "arm2.position"], 2e-5),
        ("quanser_qube", 7, 8, ["arm.position", "pole.position"], 0.00307 / np.sqrt(12)),
        ("quanser_cartpole", 7, 8, ["cart.position", "pole.position"], None),
        ("servo_xl330", 8, 8, ["link.position"], 0.00153 / np.sqrt(12)),
        ("servo_sts3250", 2, 2, ["link.position"], None),
        ("ball_drops", 1, 1, ["ball.position"], None),
        ("cube_toss", 20, 120, [f"sensor.cube_{what}" for what in CUBE], None),
    ],
)
def test_logs_channels_and_noise(name: str, fit: int, held_out: int, channels: list[str], std: float | None) -> None:
    found = load(name)
    assert (len(found.fit), len(found.held_out)) == (fit, held_out)
    assert list(found.noise) == channels
    for channel, noise in found.noise.items():
        # Documented quanta of positions give the least; jitter of the stamps adds up to twice as much.
        assert std is None or channel.endswith("velocity") or 0.95 * std < noise.std < 3.0 * std
    kinds = {note.kind for log in (*found.fit, *found.held_out) for note in log.notes}
    assert kinds <= {"glitches", "wrapped"}


def accelerations(signal: Signal, half_width: float) -> tuple[Array, Array, Array]:
    fit = local_polynomial(signal, signal.time, half_width)
    return fit.value, fit.slope, fit.curvature


@real
def test_the_pendulum_s_motor_reports_its_velocity_roughly() -> None:
    found = load("dfki_simple_pendulum")
    assert 0.044 / np.sqrt(12) < found.noise["pendulum.velocity"].std < 0.2  # rad/s; above the quantum of SOURCE.md


@real
@pytest.mark.parametrize(("name", "sign"), [("multiarm_single", -1.0), ("dfki_simple_pendulum", -1.0)])
def test_pendulums_hang_at_zero(name: str, sign: float) -> None:
    """Near rest the acceleration opposes the sine of the angle, with the pendulum's own frequency."""
    for log in load(name).held_out:
        signal = next(signal for name, signal in log.outputs.items() if name.endswith("position"))
        angle, _, acceleration = accelerations(signal, 0.04)
        force = next(iter(log.commands.values()), None)
        held = np.zeros(len(signal)) if force is None else np.interp(signal.time, force.time, force.value)
        basis = np.stack([np.sin(angle), held], axis=1)
        stiffness = np.linalg.lstsq(basis, acceleration, rcond=None)[0][0]
        assert 10 < sign * stiffness < 100


@real
@pytest.mark.parametrize(
    ("name", "base", "pole", "coupling"),
    [("quanser_qube", "arm", "pole", 0.988), ("quanser_cartpole", "cart", "pole", 3 / (4 * 0.168))],
)
def test_pole_and_base_are_coupled_as_in_the_model(name: str, base: str, pole: str, coupling: float) -> None:
    """p'' = −c cos(p) b'' − ω² sin(p), c = L / (4/3 l) for the arm of length L and 1 / (4/3 l) for the cart."""
    chirps = [log for log in load(name).fit if "chirp" in log.name]
    rows = []
    for log in chirps:
        _, _, push = accelerations(log.outputs[f"{base}.position"], 0.03)
        angle, speed, acceleration = accelerations(log.outputs[f"{pole}.position"], 0.03)
        rows.append(np.stack([-np.cos(angle) * push, -np.sin(angle), -speed, acceleration], axis=1))
    data = np.concatenate(rows)
    found = np.linalg.lstsq(data[:, :3], data[:, 3], rcond=None)[0]
    assert 0.1 * coupling < found[0] < 1.2 * coupling
    assert 30 < found[1] < 150


@real
def test_heavy_ball_falls_freely_and_light_one_does_not() -> None:
    def acceleration(ball: str) -> float:
        (log,) = load("ball_drops", f"measurements.fit=[{ball}/1]", "measurements.held_out=[]").fit
        signal = log.outputs["ball.position"]
        return 2 * np.polyfit(signal.time, signal.value, 2)[0]

    assert acceleration("bowling_ball") == pytest.approx(-9.81, rel=0.05)
    assert -5.0 < acceleration("yellow_whiffle_ball") < -2.0


@real
def test_cube_turns_as_its_quaternions_and_rests_on_a_face() -> None:
    found = load("cube_toss", "measurements.fit=[tosses_000_299/1?]", "measurements.held_out=[]").fit
    assert [log.name for log in found] == [f"tosses_000_299/{k}" for k in range(10, 20)]
    for log in found:
        position, orientation = (log.outputs[f"sensor.cube_{name}"] for name in ("position", "orientation"))
        assert position.time[1] == pytest.approx(1 / 148)
        np.testing.assert_allclose(np.linalg.norm(orientation.value, axis=1), 1.0, atol=1e-5)
        assert np.abs(np.diff(orientation.value, axis=0)).max() < 0.1  # of one sign throughout
        assert position.value[-1, 2] == pytest.approx(0.0512, abs=0.001)


@real
def test_servo_s_duty_is_what_its_firmware_makes_of_the_target() -> None:
    path = Path(DATA or "") / "servo_bam" / "xl330_sin_sin_kp100_m0.49_l0.1.csv"
    table = np.genfromtxt(path, delimiter=",", names=True)
    voltage = next(log for log in load("servo_xl330").fit if log.name == path.stem).commands["motor"]
    duty = 100 * (table["goal_rad"] - table["q_rad"]) * (4096 / (2 * np.pi)) / (256 * 885)
    np.testing.assert_allclose(voltage.value, 7.3 * np.clip(duty, -1, 1), atol=0.3)


@real
def test_mcap_and_csv_of_one_run_agree(contract: DataContract) -> None:
    folder = Path(DATA or "") / "dfki_double_pendulum" / "C1_sysid"
    outputs = {"shoulder.position": {"topic": "/joint_states", "field": "position[shoulder]", "unit": "rad"}}
    commands = {"elbow": {"topic": "/joint_states", "field": "effort[elbow]", "unit": "N·m"}}
    packed = read_log(folder / "143339.mcap", outputs, commands, contract, clock="header")
    table = next(log for log in load("dfki_c1").fit if log.name == "143339")
    for mine, theirs in (
        (packed.outputs["shoulder.position"], table.outputs["shoulder.position"]),
        (packed.commands["elbow"], table.commands["elbow"]),
    ):
        np.testing.assert_allclose(mine.time, theirs.time, atol=2e-9)
        np.testing.assert_array_equal(mine.value, theirs.value)
    assert packed.clocks["shoulder.position"].offset == 0.0


@real
@pytest.mark.parametrize("column", ["pos_meas1", "pos_meas2"])
def test_degrees_in_a_real_log_are_found(tmp_path: Path, contract: DataContract, column: str) -> None:
    table = np.genfromtxt(
        Path(DATA or "") / "dfki_double_pendulum" / "C1_sysid" / "143339.csv", delimiter=",", names=True
    )
    rows = np.stack([table["time_s"], np.rad2deg(table[column]), table[column.replace("pos", "vel")]], axis=1)
    np.savetxt(tmp_path / "a.csv", rows, delimiter=",", header="t,q,v", comments="", fmt="%.9g")
    velocity = {"j.velocity": {"column": "v", "unit": "rad/s"}}
    position = {"j.position": {"column": "q", "unit": "rad"}}
    with pytest.raises(DataError, match=r"j\.position is in degrees .*write unit: deg"):
        read_log(tmp_path / "a.csv", position | velocity, {}, contract, time=TimeAxis("t"))


def test_without_the_variable_the_error_says_what_to_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DR_LAB_DATA", raising=False)
    with pytest.raises(
        InstantiationException, match=r"Environment variable DR_LAB_DATA is not set.*export DR_LAB_DATA=FOLDER"
    ):
        load("emps")
