"""Averages of returns, by hand."""

import numpy as np
import pytest

from dr_lab.distribution_learners.return_statistics import ReturnStatistics


def test_the_first_batch_is_standardised_by_itself() -> None:
    standardised = ReturnStatistics(rate=0.01).standardise(np.array([1.0, 3.0]))
    np.testing.assert_allclose(standardised, [-1.0, 1.0])


def test_two_batches_are_averaged_with_their_weights() -> None:
    statistics = ReturnStatistics(rate=0.5)
    statistics.standardise(np.array([1.0, 3.0]))  # mean 2, std 1
    # Weights 0.25 and 0.5, of 0.75: mean (0.25·2 + 0.5·8)/0.75 = 6, std (0.25·1 + 0.5·4)/0.75 = 3.
    np.testing.assert_allclose(statistics.standardise(np.array([4.0, 12.0])), [-2 / 3, 2.0])


def test_an_infeasible_context_counts_as_the_worst_seen() -> None:
    statistics = ReturnStatistics(rate=1.0)
    statistics.standardise(np.array([-5.0, 3.0]))
    np.testing.assert_allclose(
        statistics.standardise(np.array([np.nan, 5.0])), statistics.standardise(np.array([-5.0, 5.0]))
    )


def test_batches_before_any_feasible_context_say_nothing_later_either() -> None:
    begun, fresh = ReturnStatistics(rate=0.1), ReturnStatistics(rate=0.1)
    for _ in range(5):
        begun.standardise(np.array([np.nan, np.nan]))
    returns = np.array([10.0, 20.0, np.nan])
    np.testing.assert_allclose(begun.standardise(returns), fresh.standardise(returns))
    assert begun.standardise(returns)[2] < 0.0


def test_equal_and_altogether_infeasible_returns_say_nothing() -> None:
    assert (ReturnStatistics(rate=0.1).standardise(np.array([2.0, 2.0])) == 0.0).all()
    assert ReturnStatistics(rate=0.1).standardise(np.array([np.nan, np.nan])) == pytest.approx(0.0)
