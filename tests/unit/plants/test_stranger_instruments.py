"""Coloured noise by its spectrum and its variance, velocities of differences, and commands that are logged seldom."""

from collections.abc import Mapping

import numpy as np
import pytest
from hydra.utils import instantiate
from scipy.interpolate import CubicSpline
from scipy.signal import welch

from dr_lab.cli.compose import compose
from dr_lab.errors import ConfigError
from dr_lab.plants.filtered_difference import FilteredDifference
from dr_lab.plants.noise import CorrelatedNoise, LowPassedNoise, Noise, WhiteNoise
from dr_lab.plants.rig import Rig

RATE, COUNT, STD = 500.0, 200_000, 5e-4
NOISES: Mapping[str, tuple[Noise, float]] = {  # with the corner of its spectrum in Hz, where half of the power is left
    "correlated": (CorrelatedNoise(STD, 0.02), 1 / (2 * np.pi * 0.02)),
    "low_passed": (LowPassedNoise(STD, 20.0), 20.0),
}


@pytest.mark.parametrize("name", NOISES)
def test_the_spectrum_falls_to_half_at_the_corner(name: str) -> None:
    noise, corner = NOISES[name]
    drawn = noise.draw(COUNT, RATE, np.random.default_rng(2))
    assert drawn.std() == pytest.approx(STD, rel=0.03)
    frequency, density = welch(drawn, fs=RATE, nperseg=4096)
    flat = density[(frequency > 0.3) & (frequency < corner / 5)].mean()
    near = np.abs(frequency - corner) < corner / 20
    assert density[near].mean() / flat == pytest.approx(0.5, abs=0.05)
    # White noise of this deviation has the same density: σ² over half of the rate.
    assert flat == pytest.approx(noise.white_equal(RATE) ** 2 / (RATE / 2), rel=0.07)


def test_correlation_falls_to_a_share_of_e() -> None:
    drawn = CorrelatedNoise(1.0, 0.02).draw(COUNT, RATE, np.random.default_rng(3))
    assert np.mean(drawn[10:] * drawn[:-10]) == pytest.approx(np.exp(-1), abs=0.02)  # 10 samples are 20 ms


def test_white_noise_is_its_own_equal() -> None:
    assert WhiteNoise(STD).white_equal(RATE) == STD
    assert WhiteNoise(STD).draw(COUNT, RATE, np.random.default_rng(4)).std() == pytest.approx(STD, rel=0.01)


def test_a_corner_that_no_samples_show_is_refused() -> None:
    with pytest.raises(ConfigError, match="corner at 300 Hz; expected less than half of the sample rate, which is 500"):
        LowPassedNoise(STD, 300.0).draw(COUNT, 500.0, np.random.default_rng(5))


def test_filtered_differences_of_even_motion_settle_exponentially() -> None:
    time = np.arange(200) / RATE
    velocity = FilteredDifference(30.0).velocity(time, 3.0 * time[:, None], RATE)[:, 0]
    expected = 3.0 * (1 - np.exp(-2 * np.pi * 30.0 / RATE * np.arange(200)))
    np.testing.assert_allclose(velocity, expected, rtol=0, atol=1e-12)


def bench(*overrides: str) -> Rig:
    return instantiate(
        compose("record", ["plant=pendulum", "plant.duration=0.4", "plant.peaks=[2.0]", *overrides]).plant
    )


def test_one_of_five_commands_is_logged_and_all_act() -> None:
    (sparse,) = bench("plant/instruments=sparse").recordings(1)
    (white,) = bench("plant/instruments=white", "plant.instruments.sample_rate=50.0").recordings(1)
    np.testing.assert_array_equal(sparse.command, white.command[::5])
    np.testing.assert_array_equal(sparse.command_time, white.command_time[::5])
    np.testing.assert_array_equal(sparse.position, white.position)
    assert np.diff(sparse.stamp).mean() == pytest.approx(0.02, rel=1e-3)


def test_velocities_come_of_the_logged_positions() -> None:
    (log,) = bench("plant/instruments=differenced").recordings(1)
    assert log.velocity is not None
    expected = FilteredDifference(30.0).velocity(log.stamp, log.position, 500.0)
    np.testing.assert_array_equal(log.velocity, expected)


def test_tachometers_measure_the_true_motion_with_noise_of_their_own() -> None:
    own = ["plant/instruments=tachometers", "plant.instruments.sample_jitter=0.0", "plant.instruments.noise.std=0.0"]
    (log,) = bench(*own).recordings(1)
    (silent,) = bench(*own, "plant.instruments.velocity.std=0.0").recordings(1)
    assert log.velocity is not None
    assert silent.velocity is not None
    np.testing.assert_array_equal(log.position, silent.position)
    blurred = log.velocity - silent.velocity
    assert blurred.std() == pytest.approx(0.02, rel=0.15)
    spline = CubicSpline(silent.stamp, silent.position)
    # Jumps of the torque bend the motion between samples.
    np.testing.assert_allclose(spline(silent.stamp, 1)[5:-5], silent.velocity[5:-5], rtol=0, atol=0.02)


def test_a_filter_of_velocities_shows_in_them_alone() -> None:
    silent = ["plant/instruments=tachometers", "plant.instruments.velocity.std=0.0", "plant.instruments.noise.std=0.0"]
    filtered = ["plant/hidden=general/velocity_low_pass", "plant.hidden.site=pendulum", "plant.hidden.constant=0.005"]
    (plain,), (late,) = bench(*silent).recordings(1), bench(*silent, *filtered).recordings(1)
    assert plain.velocity is not None
    assert late.velocity is not None
    np.testing.assert_allclose(late.position, plain.position, rtol=0, atol=1e-6)
    # tau w' + w = q', integrated: tau (w(b) − w(a)) = q(b) − q(a) − ∫ w
    integral = CubicSpline(late.stamp, late.velocity).integrate(late.stamp[10], late.stamp[-10])
    lag = (late.position[-10] - late.position[10] - integral) / (late.velocity[-10] - late.velocity[10])
    assert lag == pytest.approx(0.005, rel=0.02)


def test_a_filter_of_velocities_that_nothing_measures_is_refused() -> None:
    filtered = ["plant/hidden=general/velocity_low_pass", "plant.hidden.site=pendulum", "plant.hidden.constant=0.005"]
    with pytest.raises(Exception, match=r"measure none\. Give plant/instruments=tachometers"):
        bench(*filtered)


def test_noise_and_counts_add_up() -> None:
    instruments = bench("plant/instruments=quantised").instruments
    assert instruments.white_equal() == pytest.approx(np.hypot(1e-4, 2 * np.pi / 4096 / np.sqrt(12)))
