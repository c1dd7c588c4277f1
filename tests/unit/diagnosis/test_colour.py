import numpy as np
import pytest
from scipy.signal import butter, lfilter, sosfilt

from dr_lab.diagnosis.evidence.colour import instrumental
from dr_lab.diagnosis.fit.correlation import autocorrelation, by_component, correlation_time, variance_time
from dr_lab.trajectory import Array

WINDOWS, SAMPLES, STEP = 24, 150, 0.002  # 0.3 s each


def random(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def every(residual: Array) -> np.ndarray:
    return np.ones(residual.shape, bool)


def cut(series: Array) -> Array:
    return series[-WINDOWS * SAMPLES :].reshape(WINDOWS, SAMPLES)


def less_a_line(rows: Array) -> Array:
    """What is left of windows whose start position and velocity are fitted."""
    basis = np.linalg.qr(np.vander(np.linspace(-1, 1, rows.shape[1]), 2))[0]
    return rows - rows @ basis @ basis.T


def correlated(seed: int, time: float) -> Array:
    keep = np.exp(-STEP / time)
    return np.asarray(
        lfilter([np.sqrt(1 - keep**2)], [1, -keep], random(seed).standard_normal(WINDOWS * SAMPLES + 1000))
    )


def low_passed(seed: int, cutoff: float) -> Array:
    sections = butter(2, cutoff, fs=1 / STEP, output="sos")
    return np.asarray(sosfilt(sections, random(seed).standard_normal(WINDOWS * SAMPLES + 1000)))


def pushed(seed: int, force: Array | None = None, size: float = 10.0) -> Array:
    """What a force leaves of positions, in noise standard deviations, beside that noise."""
    force = random(seed).standard_normal((WINDOWS, SAMPLES)) if force is None else force
    moved = less_a_line(np.cumsum(np.cumsum(force, axis=1), axis=1))
    return size * moved / moved.std() + random(seed + 1).standard_normal(moved.shape)


@pytest.mark.parametrize("time", [0.004, 0.02])
def test_the_correlation_time_is_that_of_the_process(time: float) -> None:
    """Of ρ_k = a^k, 1 + 2 Σ ρ_k = (1 + a)/(1 − a), and with a² in place of a for squares."""
    keep = np.exp(-STEP / time)
    rho = autocorrelation(rows := correlated(0, time)[-3600:].reshape(6, 600), every(rows))
    assert correlation_time(rho) == pytest.approx((1 + keep) / (1 - keep), rel=0.35)
    assert variance_time(rho) == pytest.approx((1 + keep**2) / (1 - keep**2), rel=0.35)


def test_white_noise_has_no_colour() -> None:
    rows = random(0).standard_normal((WINDOWS, SAMPLES))
    assert correlation_time(autocorrelation(rows, every(rows))) == pytest.approx(1.0, abs=0.2)


def test_samples_that_do_not_exist_have_no_say() -> None:
    rows, used = random(0).standard_normal((WINDOWS, SAMPLES)), random(1).uniform(size=(WINDOWS, SAMPLES)) < 0.7
    spoilt = np.where(used, rows, 1e6)
    assert autocorrelation(spoilt, used)[1] == pytest.approx(0.0, abs=0.05)


def test_residuals_that_no_window_has_have_no_correlation() -> None:
    none = by_component(np.empty((WINDOWS, 0, 2)))
    assert none.shape == (2 * WINDOWS, 0)
    assert correlation_time(autocorrelation(none, every(none))) == 1.0


@pytest.mark.parametrize("seed", range(5))
def test_noise_of_instruments_is_told_from_forces(seed: int) -> None:
    white = 3 * random(seed).standard_normal((WINDOWS, SAMPLES))
    for noise in (white, 6 * cut(correlated(seed, 0.02)), 47 * cut(low_passed(seed, 20.0))):
        rows = less_a_line(noise)
        assert instrumental(rows, every(rows), 2)


@pytest.mark.parametrize("seed", range(5))
def test_noise_that_is_hardly_larger_than_it_is_known_but_correlated_is_told_from_forces(seed: int) -> None:
    """Over nine samples: of what is known as white noise most is correlated, too."""
    rows = less_a_line(1.2 * cut(correlated(seed, STEP / np.log(1 / 0.8))))
    assert 1.1 < float((rows**2).mean()) < 1.6
    assert instrumental(rows, every(rows), 2)


@pytest.mark.parametrize("seed", range(5))
def test_what_a_force_left_is_no_noise(seed: int) -> None:
    """White force, dry friction that changes sign at times, a constant force, and a vibration that comes and goes."""
    time, rng = STEP * np.arange(SAMPLES), random(seed)
    swing = np.sin(2 * np.pi * rng.uniform(0.5, 3, (WINDOWS, 1)) * time + rng.uniform(0, 6, (WINDOWS, 1)))
    vibration = rng.lognormal(0, 0.7, (WINDOWS, 1)) * np.sin(2 * np.pi * 15 * time + rng.uniform(0, 6, (WINDOWS, 1)))
    left = (pushed(seed), pushed(seed, np.sign(swing)), pushed(seed, np.ones((WINDOWS, SAMPLES))), 10 * vibration)
    assert not any(instrumental(rows, every(rows), 2) for rows in left)


@pytest.mark.parametrize("seed", range(5))
def test_what_a_force_left_is_no_noise_where_it_is_as_large_as_that(seed: int) -> None:
    """Over few windows the scatter of the noise's power is as rough as it."""
    rows = pushed(seed, size=1.0)[:10]
    assert not instrumental(rows, every(rows), 2)
    noise = np.sqrt(2) * random(seed).standard_normal((10, SAMPLES))
    assert instrumental(less_a_line(noise), every(noise), 2)


def test_of_windows_without_enough_samples_nothing_is_said() -> None:
    rows = 3 * random(0).standard_normal((WINDOWS, 8))
    assert not instrumental(rows, every(rows), 2)
