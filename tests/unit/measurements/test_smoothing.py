"""Local polynomials: exact on polynomials, right noise gains, causal when asked to be."""

import numpy as np
import pytest

from dr_lab.errors import DataError
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.trajectory import Signal


def uneven(count: int, seed: int = 0) -> np.ndarray:
    return np.cumsum(np.random.default_rng(seed).uniform(0.5e-3, 3.5e-3, count))


def test_a_cubic_on_uneven_samples_is_reproduced_with_its_derivatives_up_to_the_ends() -> None:
    time = uneven(400)
    cubic = np.polynomial.Polynomial([0.3, -2.0, 5.0, 7.0])
    at = np.linspace(time[0], time[-1], 33)
    fit = local_polynomial(Signal("q", "rad", time, cubic(time)), at, 0.03)
    np.testing.assert_allclose(fit.value, cubic(at), atol=1e-12)
    np.testing.assert_allclose(fit.slope, cubic.deriv()(at), atol=1e-9)
    np.testing.assert_allclose(fit.curvature, cubic.deriv(2)(at), atol=1e-6)


def test_noise_gains_predict_the_scatter() -> None:
    rng = np.random.default_rng(1)
    time = uneven(60)
    fits = [local_polynomial(Signal("q", "rad", time, rng.normal(0, 0.1, 60)), time[20], 0.03) for _ in range(2000)]
    assert np.std([f.value for f in fits]) == pytest.approx(0.1 * float(fits[0].value_gain), rel=0.06)
    assert np.std([f.slope for f in fits]) == pytest.approx(0.1 * float(fits[0].slope_gain), rel=0.06)


def test_samples_after_until_have_no_influence() -> None:
    time = np.linspace(0, 1, 101)
    past = np.sin(time)
    spoilt = np.where(time > 0.5, 1e6, past)
    fit = local_polynomial(Signal("q", "rad", time, spoilt), 0.5, 0.1, until=0.5)
    assert float(fit.value) == pytest.approx(np.sin(0.5), abs=1e-6)
    assert float(fit.slope) == pytest.approx(np.cos(0.5), abs=1e-3)


def test_vector_signals_are_fitted_by_column_and_scalars_keep_their_shape() -> None:
    time = np.linspace(0, 1, 50)
    value = np.stack([time, -2 * time, time**2], axis=1)
    fit = local_polynomial(Signal("sensor.gyro", "rad/s", time, value), [0.2, 0.7], 0.1)
    np.testing.assert_allclose(fit.slope, [[1, -2, 0.4], [1, -2, 1.4]], atol=1e-9)
    assert local_polynomial(Signal("q", "rad", time, time), 0.5, 0.1).value.shape == ()


def test_a_window_without_samples_takes_the_nearest() -> None:
    time = np.concatenate([np.linspace(0, 1, 20), np.linspace(5, 6, 20)])
    fit = local_polynomial(Signal("q", "rad", time, 3 * time), 3.0, 0.01, degree=1)
    assert float(fit.value) == pytest.approx(9.0)


def test_too_few_samples_say_how_many_are_needed() -> None:
    with pytest.raises(DataError, match=r"3 samples up to inf s; .* degree 3 needs 4"):
        local_polynomial(Signal("q", "rad", np.arange(3.0), np.zeros(3)), 1.0, 0.1)


@pytest.mark.parametrize("width", [0.03, 2e-3])  # the narrow one takes the nearest samples
def test_many_times_at_once_are_those_one_by_one_each_with_its_own_last_sample(width: float) -> None:
    rng = np.random.default_rng(3)
    time = uneven(300)
    signal = Signal("q", "rad", time, np.sin(9 * time) + rng.normal(0, 0.01, 300))
    at = rng.uniform(time[0], time[-1], 40)
    until = np.maximum(at + rng.uniform(-0.25 * width, 0.05, 40), time[5])
    at_once = local_polynomial(signal, at, width, until)
    for k in range(40):
        alone = local_polynomial(signal, at[k], width, until[k])
        for part, whole in zip(alone, at_once, strict=True):
            assert whole[k] == pytest.approx(float(part), rel=1e-9, abs=1e-9)


def test_of_many_times_the_one_with_too_few_samples_is_told() -> None:
    time = np.arange(10.0)
    with pytest.raises(DataError, match=r"3 samples up to 2.5 s"):
        local_polynomial(Signal("q", "rad", time, time), [5.0, 6.0], 2.0, until=[9.0, 2.5])


def test_few_samples_are_not_gone_through() -> None:
    """At a low rate the nearest six smooth a cubic's noise, where four would be reproduced."""
    time = np.linspace(0, 1, 11)
    noise = np.random.default_rng(3).normal(size=11)
    fit = local_polynomial(Signal("q", "rad", time, noise), 0.5, 0.01)
    nearest = np.polynomial.Polynomial.fit(time[2:8], noise[2:8], 3)
    assert float(fit.value) == pytest.approx(nearest(0.5))
    assert float(local_polynomial(Signal("q", "rad", time[:5], noise[:5]), 0.2, 0.01).value) == pytest.approx(
        np.polynomial.Polynomial.fit(time[:5], noise[:5], 3)(0.2)
    )


@pytest.mark.parametrize("until", [np.inf, 3.0])
def test_a_straight_line_bridges_a_gap(until: float) -> None:
    """Cubics through the milliseconds beside a gap tell nothing of its middle, and are singular where it is long."""
    time = np.concatenate([np.arange(0.0, 1.0, 0.002), np.arange(3.0, 4.0, 0.002)])
    value = np.stack([np.sin(time), np.cos(time)], axis=1)
    at = np.linspace(1.01, 2.99, 41)
    fit = local_polynomial(Signal("q", "rad", time, value + 1e-3 * np.cos(1e4 * time)[:, None]), at, 0.03, until)
    line = np.stack([np.interp(at, time, column) for column in value.T], axis=1)
    np.testing.assert_allclose(fit.value, line, atol=2e-3)
    np.testing.assert_allclose(
        fit.slope, np.tile(np.diff(value[499:501], axis=0) / (3.0 - time[499]), (41, 1)), atol=2e-3
    )
    assert (fit.value_gain <= 1).all()
