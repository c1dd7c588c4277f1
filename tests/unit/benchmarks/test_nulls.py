"""The nulls that the statistic of evidence is calibrated on are what they claim to be."""

import numpy as np
import pytest
from calibration import nulls
from nulls.machines import PENDULUM, PERIOD, Missing, move
from nulls.noise import CORRELATION, CUTOFF, NOISES
from scipy.signal import welch

STD = 1e-3
COUNT = 200_000


def error_of(kind: str) -> np.ndarray:
    """What a kind of noise adds to a signal that moves by many of its steps."""
    clean = np.sin(0.7 * PERIOD * np.arange(COUNT))
    return NOISES[kind](clean, PERIOD, STD, np.random.default_rng(1)) - clean


@pytest.mark.parametrize("kind", NOISES)
def test_every_noise_has_the_standard_deviation_it_is_asked_for(kind: str) -> None:
    assert np.std(error_of(kind)) == pytest.approx(STD, rel=0.03)


@pytest.mark.parametrize("lag", [1, 10, 20])
def test_coloured_noise_forgets_exponentially(lag: int) -> None:
    error = error_of("coloured")
    correlation = np.mean(error[lag:] * error[:-lag]) / np.mean(error**2)
    assert correlation == pytest.approx(np.exp(-lag * PERIOD / CORRELATION), abs=0.03)


def test_coloured_and_low_passed_noise_begin_as_they_go_on() -> None:
    for kind in ("coloured", "low_passed"):
        firsts = [NOISES[kind](np.zeros(2), PERIOD, STD, np.random.default_rng(k))[0] for k in range(1000)]
        assert np.std(firsts) == pytest.approx(STD, rel=0.08)


def test_low_passed_noise_has_the_spectrum_of_a_butterworth_filter() -> None:
    frequency, power = welch(error_of("low_passed"), 1 / PERIOD, nperseg=2000)
    plateau = power[(frequency > 1) & (frequency < 8)].mean()
    assert power[np.argmin(abs(frequency - CUTOFF))] / plateau == pytest.approx(0.5, rel=0.15)
    assert power[np.argmin(abs(frequency - 3 * CUTOFF))] / plateau < 1 / 60  # 1/(1 + 3⁴), the bilinear map a bit less


def test_white_noise_has_a_flat_spectrum() -> None:
    frequency, power = welch(error_of("white"), 1 / PERIOD, nperseg=1000)
    halves = power[(frequency > 5) & (frequency < 125)].mean(), power[frequency > 125].mean()
    assert halves[0] == pytest.approx(halves[1], rel=0.05)


def test_a_simulated_machine_starts_alike_and_parts_by_its_model_error() -> None:
    plain, wrong = (
        move(PENDULUM, 2, Missing("slosh", size), np.random.default_rng(3)).positions for size in (0.0, 0.2)
    )
    np.testing.assert_array_equal(plain[:, 0], wrong[:, 0])
    assert 0.01 < np.sqrt(np.mean((plain - wrong) ** 2)) < 1.0


def test_every_null_has_a_seed_of_its_own_whichever_others_are_asked_for() -> None:
    many = nulls(["white", "coloured"], [0.0, 0.4, 1.0], 24)
    assert len({null.seed for null in many}) == 24
    few = nulls(["white"], [0.4], 4)
    assert {null.seed for null in few} == {null.seed for null in many if (null.noise, null.size) == ("white", 0.4)}
