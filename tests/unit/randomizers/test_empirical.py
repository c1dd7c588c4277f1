"""Contexts out of those that were noted."""

import numpy as np
import pytest
from randomizer_samples import SPACE
from scipy.stats import kstest, uniform

from dr_lab.errors import ConfigError
from dr_lab.randomizers.empirical import EmpiricalRandomizer

NOTED = np.array([[0.6, 0.0], [1.5, 0.5], [1.5, 0.9]])


def empirical(window: int = 100) -> EmpiricalRandomizer:
    return EmpiricalRandomizer(SPACE, {"friction": [0.0, 1.0]}, window, bins=4)


def test_it_is_uniform_within_the_ranges_before_anything_is_noted() -> None:
    randomizer = empirical()
    z = randomizer.sample([np.random.default_rng(0)] * 2000)
    for column, (low, high) in zip(z.T, ((0.5, 2.5), (0.0, 1.0)), strict=True):
        assert kstest(column, uniform(low, high - low).cdf).pvalue > 1e-3
    np.testing.assert_allclose(randomizer.marginal(1), 0.25)
    np.testing.assert_allclose(randomizer.edges(1), [0.0, 0.25, 0.5, 0.75, 1.0])


def test_every_noted_context_is_as_likely_as_the_others() -> None:
    randomizer = empirical()
    randomizer.note(NOTED, 10)
    z = randomizer.sample([np.random.default_rng(0)] * 6000)
    found, counts = np.unique(z, axis=0, return_counts=True)
    np.testing.assert_array_equal(found, NOTED)
    np.testing.assert_allclose(counts / 6000, 1 / 3, atol=0.03)
    np.testing.assert_allclose(randomizer.marginal(0), [1 / 3, 0.0, 2 / 3, 0.0])
    assert randomizer.moments() is None


def test_what_is_older_than_the_window_is_forgotten() -> None:
    randomizer = empirical(window=100)
    randomizer.note(NOTED[:1], 10)
    randomizer.note(NOTED[1:], 109)
    assert len(np.unique(randomizer.sample([np.random.default_rng(0)] * 100), axis=0)) == 3
    randomizer.note(NOTED[1:2], 110)
    np.testing.assert_allclose(randomizer.marginal(0), [0.0, 0.0, 1.0, 0.0])


def test_its_state_holds_what_is_noted() -> None:
    randomizer, other = empirical(), empirical()
    randomizer.note(NOTED, 10)
    other.load_state_dict(randomizer.state_dict())
    first, second = (each.sample([np.random.default_rng(3)] * 20) for each in (randomizer, other))
    np.testing.assert_array_equal(first, second)


def test_a_window_that_holds_nothing_is_told() -> None:
    with pytest.raises(ConfigError, match=r"randomizer\.window is 0; expected at least 1"):
        empirical(window=0)
