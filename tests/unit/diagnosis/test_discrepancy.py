from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    log_of,
    model_of,
    pendulum,
    predicted_settings,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
    windows_settings,
)
from scipy.signal import lfilter

from dr_lab.diagnosis.discrepancy import InputCorrelation, horizon_error, input_correlations
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log

BLOCK = """<mujoco model="block"><compiler angle="radian"/><option timestep="0.002" gravity="0 0 0"/>
  <worldbody><body><joint name="hinge" type="slide" axis="1 0 0"/><geom size="0.1" mass="2"/></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
  <sensor><actuatorfrc name="force" actuator="drive"/></sensor></mujoco>"""
LAGS = 25


def fitted(model: Model, logs: list[Log], settings: WindowSettings) -> tuple[Replay, Point]:
    return fit_states(model, model.space.nominal, windows_of(model, logs, settings), solver_settings(), 1)


def test_a_missing_acceleration_grows_with_the_square_of_the_horizon() -> None:
    settings = predicted_settings(seconds=0.3)
    start, push = settings.past + settings.margin + settings.run_in, 0.6

    def late(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = push if data.time > start - 1e-9 else 0.0

    model, command = model_of(BLOCK), steps_command("drive", 1.0, 0.6, seed=0)
    motion = simulated(model.nominal(), command, 0.6, force=late)
    replay, fit = fitted(
        model, [log_of("a", {"hinge.position": (motion["time"], motion["qpos"][:, 0])}, command)], settings
    )
    found = horizon_error(replay, fit, settings.run_in, settings.margin, 12)
    error, edges = found.rmse["hinge.position"][-6:], found.horizon[-7:]
    low, high = (0.5 * push / 2.0 * t**2 for t in (edges[:-1], edges[1:]))  # ½ (F/m) t²
    assert (low < error).all()
    assert (error < high).all()
    assert np.polyfit(np.log(edges[1:]), np.log(error), 1)[0] == pytest.approx(2.0, abs=0.05)


def test_the_first_horizon_is_one_step_and_the_last_the_whole_window() -> None:
    settings = predicted_settings()
    replay, fit = fitted(pendulum(), [swinging("a", pendulum().nominal(), 0)], settings)
    found = horizon_error(replay, fit, settings.run_in, settings.margin, 6)
    assert found.horizon[0] == pytest.approx(0.002)
    assert found.horizon[-1] == pytest.approx(settings.length, abs=0.004)
    assert np.isfinite(found.rmse["hinge.position"]).all()
    assert found.rmse["hinge.position"][0] == pytest.approx(NOISE, rel=0.5)


def test_a_single_horizon_is_the_whole_window() -> None:
    settings = predicted_settings()
    replay, fit = fitted(pendulum(), [swinging("a", pendulum().nominal(), 0)], settings)
    one, some = (horizon_error(replay, fit, settings.run_in, settings.margin, bins) for bins in (1, 6))
    np.testing.assert_array_equal(one.horizon, some.horizon[-1:])
    error = NOISE * np.sqrt(np.square(fit.residuals[replay.scored]).mean())
    assert one.rmse["hinge.position"] == pytest.approx(error, rel=0.01)


def correlation(late: int, seed: int = 0) -> InputCorrelation:
    """Correlation of a force reading that also shows the command of `late` samples earlier."""
    model, command = model_of(BLOCK), steps_command("drive", 1.0, 3.0, seed, period=0.002)
    motion = simulated(model.nominal(), command, 3.0)
    reading = motion["sensordata"][:, 0] + 0.5 * np.roll(motion["sensordata"][:, 0], late)
    log = log_of("a", {"sensor.force": (motion["time"], reading)}, command)
    replay = Replay(model, windows_of(model, [log]), 1)
    residuals, infeasible = replay.residuals(np.zeros((1, 0)), np.zeros((1, len(replay.windows), 2)))
    point = Point(np.zeros(0), np.zeros((len(replay.windows), 2)), residuals[0], 0.0, infeasible[0])
    return input_correlations(replay, point, replay.commands, LAGS)[0]


@pytest.mark.parametrize("late", [0, 4, 20, -6])
def test_a_command_that_acts_late_is_found_at_its_lag(late: int) -> None:
    found = correlation(late)
    lag, peak = found.peak
    assert lag == pytest.approx(0.002 * late)
    assert peak > 0.95
    assert found.band < 0.2


def point_of(replay: Replay, residuals: Array) -> Point:
    return Point(np.zeros(2), np.zeros((len(replay.windows), 2)), residuals, 0.0, np.zeros(len(replay.windows), bool))


@pytest.mark.parametrize("colour", [0.0, 0.95])
def test_independent_residuals_stay_within_the_band(colour: float) -> None:
    command = steps_command("drive", 1.0, 6.0, seed=0, period=0.02)  # coloured by its hold
    log = replace(swinging("a", pendulum().nominal(), 0, seconds=6.0), commands={"drive": command})
    replay = Replay(pendulum(), windows_of(pendulum(), [log]), 1)
    rng, shape = np.random.default_rng(1), (len(replay.windows), replay.scored.shape[1])
    inside = 0
    for _ in range(300):
        noise = rng.normal(size=(shape[0], 200 + shape[1]))
        residuals = np.asarray(lfilter([1.0], [1.0, -colour], noise, axis=1))[:, 200:]
        found = input_correlations(replay, point_of(replay, residuals), replay.commands, LAGS)[0]
        inside += abs(found.peak[1]) < found.band
    assert inside >= 290  # 99 % of the peaks, three standard deviations below: 292 of 300


def test_a_command_held_longer_than_the_lags_does_not_pass_for_the_cause_of_a_growing_error() -> None:
    command = steps_command("drive", 1.0, 6.0, seed=0, period=0.6)
    log = replace(swinging("a", pendulum().nominal(), 0, seconds=6.0), commands={"drive": command})
    replay = Replay(pendulum(), windows_of(pendulum(), [log], windows_settings(length=0.6)), 1)
    rng, (windows, samples) = np.random.default_rng(1), replay.scored.shape
    inside = 0
    for _ in range(300):
        residuals = rng.normal(size=(windows, 1)) * np.linspace(0, 1, samples) ** 2
        found = input_correlations(replay, point_of(replay, residuals), replay.commands, LAGS)[0]
        inside += abs(found.peak[1]) < found.band
    assert inside >= 290  # as above


def test_slow_channels_get_fewer_lags_and_windows_that_diverge_none() -> None:
    model = pendulum()
    log = swinging("a", model.nominal(), 0)
    signal = log.outputs["hinge.position"]
    slow = log_of("a", {"hinge.position": (signal.time[::10], signal.value[::10])}, log.commands["drive"])
    replay, fit = fitted(model, [slow], predicted_settings())
    (found,) = input_correlations(replay, fit, replay.commands, LAGS)
    assert found.lag.max() == 3  # a quarter of 15 samples
    assert found.step == pytest.approx(0.02)
    wild = replace(fit, residuals=np.where(np.arange(len(fit.infeasible))[:, None] == 0, 1e9, fit.residuals))
    spared = replace(wild, infeasible=np.arange(len(fit.infeasible)) == 0)
    (told,) = input_correlations(replay, spared, replay.commands, LAGS)
    assert np.abs(told.correlation - found.correlation).max() < 0.2
    assert input_correlations(replay, replace(fit, infeasible=~fit.infeasible), replay.commands, LAGS) == []


def test_one_sample_a_window_has_a_horizon_but_no_correlation() -> None:
    model = pendulum()
    log = swinging("a", model.nominal(), 0)
    signal = log.outputs["hinge.position"]
    rare = log_of("a", {"hinge.position": (signal.time[::40], signal.value[::40])}, log.commands["drive"])
    settings = predicted_settings(length=0.07, run_in=0.4)
    replay, fit = fitted(model, [rare], settings)
    assert len(horizon_error(replay, fit, settings.run_in, settings.margin, 6).horizon) == 6
    assert input_correlations(replay, fit, replay.commands, LAGS) == []
