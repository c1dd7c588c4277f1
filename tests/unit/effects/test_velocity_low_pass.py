import numpy as np
import pytest
from effect_machines import CONF, block, placed, scales_of
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.windows.invert_reading import reach
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.effects.catalogue import candidates
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise
from tests.diagnosis_machines import log_of, pendulum, simulated, solver_settings, steps_command, windows_settings

START = np.zeros((1, 1))
TAUS = np.array([[0.0], [0.004], [0.0099]])
TIME = np.linspace(0.1, 0.2, 7)[None, None]


def quadratic(time: Array) -> Array:
    return (0.3 + time * (2.0 - 50.0 * time))[..., None]


def seen(read: Reading, channel: str) -> Array:
    model = block().with_effect(placed(block(), "velocity_low_pass", "rail"))
    return model.reading(TAUS, channel, read, START)(TIME)[:, 0, :, 0]


def test_a_quadratic_velocity_is_filtered_exactly() -> None:
    """tau y' + y = v has the particular solution v − tau v' + tau² v''."""
    t, tau = TIME[0], TAUS
    exact = quadratic(TIME)[0, :, :, 0] - tau * (2.0 - 100.0 * t) + tau**2 * -100.0
    np.testing.assert_allclose(seen(quadratic, "rail.velocity"), exact, rtol=1e-12)


@pytest.mark.parametrize("channel", ["rail.position", "other.velocity"])
def test_positions_and_other_joints_are_left_alone(channel: str) -> None:
    model = block().with_effect(placed(block(), "velocity_low_pass", "rail"))
    assert model.reading(TAUS, channel, quadratic, START) is quadratic


def test_looks_back_no_farther_than_the_windows_keep() -> None:
    model = block().with_effect(placed(block(), "velocity_low_pass", "rail"))
    bounds = np.stack([model.space.low, model.space.high])
    back = reach(lambda read: model.reading(bounds, "rail.velocity", read, START))
    assert back == pytest.approx(2 * 0.01)
    assert back <= instantiate(OmegaConf.load(CONF / "comparison" / "default.yaml").windows).margin


def test_its_bound_is_moved_as_far_as_the_windows_keep() -> None:
    effect = placed(block(), "velocity_low_pass", "rail").effect
    model = block().with_effect(placed(block(), "velocity_low_pass", "rail"))
    farthest = np.append(model.space.nominal[:-1], effect.limit("tau", kept=1.0, margin=0.03))[None]
    assert reach(lambda read: model.reading(farthest, "rail.velocity", read, START)) == pytest.approx(0.03)


@pytest.mark.parametrize(
    ("channels", "looked_for"),
    [
        (["rail.position", "rail.velocity"], True),
        (["rail.position"], False),
        (["rail.velocity"], False),  # sensor_low_pass is the same there
    ],
)
def test_it_is_looked_for_where_a_position_stands_beside_the_velocity(channels: list[str], *, looked_for: bool) -> None:
    model, one = block(), placed(block(), "velocity_low_pass", "rail")
    found = candidates(model, {one.effect.name: one.effect}, scales_of(model), model.nominal(), channels)
    assert [effect.label for effect in found.placed] == ["velocity_low_pass@rail"] * looked_for
    assert not found.refused


def drive_log(seed: int, tau: float) -> Log:
    """A pendulum by an encoder, and a drive that differences counts of its own at 2 kHz behind a filter."""
    model, command, fine = pendulum(), steps_command("drive", 1.0, 3.0, seed), 4
    motion = simulated(model.compile(np.array([0.6, 0.08])), command, 3.0, qpos=[0.8], refine=fine)
    rng, time = np.random.default_rng(seed), motion["time"]
    velocity, slow = motion["qvel"][:, 0], np.zeros(len(time))
    kept = np.exp(-(time[1] - time[0]) / tau)
    slow[0] = velocity[0]
    for k in range(1, len(time)):
        slow[k] = kept * slow[k - 1] + (1 - kept) * 0.5 * (velocity[k] + velocity[k - 1])
    reading = motion["qpos"][:, 0] + 5e-4 * rng.standard_normal(len(time))
    return log_of(
        f"log_{seed}",
        {"hinge.position": (time, reading), "hinge.velocity": (time, slow + 0.02 * rng.standard_normal(len(time)))},
        command,
    )


def test_the_filter_of_a_drive_is_found() -> None:
    tau = 6e-3
    logs = tuple(drive_log(seed, tau) for seed in range(2))
    noise = {"hinge.position": Noise(5e-4, "rad", "given"), "hinge.velocity": Noise(0.02, "rad/s", "given")}
    measured = MeasurementSet("drive", logs, (), noise, dict.fromkeys(noise, 0.1))
    plain = pendulum()
    model = plain.with_effect(placed(plain, "velocity_low_pass", "hinge"))
    windows = cut(logs, measured, plain.nominal(), windows_settings(seconds=3.0))
    fitter = Fitter(Replay(model, windows, 1), solver_settings())
    fit = fitter.run(model.space.nominal)
    assert fit.cost / fitter.replay.fitted.sum() == pytest.approx(1.0, abs=0.1)
    found = model.space.mapping(fit.z)
    assert found["velocity_low_pass@hinge.tau"] == pytest.approx(tau, rel=0.05)
    assert found["rod.mass"] == pytest.approx(0.6, rel=0.02)
