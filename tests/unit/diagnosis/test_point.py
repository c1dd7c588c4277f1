"""Weights of residuals: a glitch weighs little, a window in which the model strays weighs as any other."""

import numpy as np
import pytest

from dr_lab.diagnosis.fit.point import huber_weights

LIMIT, CHANNELS = 5.0, (slice(0, 200), slice(200, 250))
RNG = np.random.default_rng(0)


def weights(residuals: np.ndarray) -> np.ndarray:
    used = np.ones(residuals.shape, bool)
    return huber_weights(residuals, used, np.zeros(len(residuals), bool), LIMIT, CHANNELS)


def test_noise_and_a_straying_model_weigh_one_in_every_channel() -> None:
    residuals = RNG.normal(size=(3, 250))
    residuals[1, :200] += 400 * np.linspace(0, 1, 200) ** 2
    assert (weights(residuals) == 1.0).all()


def test_a_glitch_weighs_as_much_as_its_bound_over_its_size() -> None:
    residuals = np.tile([1.0, -1.0], (2, 125))
    residuals[0, 100:104] = 1000.0
    found = weights(residuals)
    np.testing.assert_allclose(found[0, 100:104], LIMIT / 1000.0)
    assert found.sum() == pytest.approx(500 - 4 * (1 - LIMIT / 1000.0))


def test_what_strays_in_one_channel_does_not_hide_a_glitch_in_another() -> None:
    residuals = np.ones((1, 250))
    residuals[0, :200] = 1e4
    residuals[0, 220] = 50.0
    assert weights(residuals)[0, 220] == pytest.approx(0.1)


def test_a_channel_without_a_sample_in_any_window_changes_no_weight() -> None:
    used = np.ones((2, 3), bool)
    found = huber_weights(np.array([[0.5, 1.0, 10.0]] * 2), used, np.zeros(2, bool), LIMIT, (slice(0, 3), slice(3, 3)))
    np.testing.assert_allclose(found, [[1.0, 1.0, 1.0]] * 2)


def test_unused_samples_and_windows_that_diverge_weigh_nothing() -> None:
    used = np.ones((2, 250), bool)
    used[0, 10:20] = False
    found = huber_weights(np.ones((2, 250)), used, np.array([False, True]), LIMIT, CHANNELS)
    assert not found[1].any()
    np.testing.assert_array_equal(found[0] == 0, ~used[0])
