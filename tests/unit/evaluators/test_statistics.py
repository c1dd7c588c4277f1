"""Statistics of a few returns against closed forms and SciPy."""

import numpy as np
import pytest
from scipy.stats import mannwhitneyu, norm

from dr_lab.evaluators.snapshots import SnapshotsEvaluator
from dr_lab.evaluators.statistics import improvement_interval, iqm_band, iqm_interval, lower_tail, means_of_contexts
from dr_lab.reports.interval_level import level


def test_the_interquartile_mean_leaves_out_a_quarter_at_each_end() -> None:
    values = np.array([100.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, -50.0, np.nan])
    found = iqm_interval(values, 0.95, 500, 0)
    assert found.value == pytest.approx(3.5)
    assert found.low < found.value < found.high
    assert iqm_interval(np.array([2.0]), 0.95, 10, 0).value == 2.0


def test_two_values_are_no_interval() -> None:
    two, three = (iqm_interval(np.array(values), 0.95, 500, 0) for values in ([1.0, 3.0], [1.0, 2.0, 3.0]))
    assert (two.value, np.isnan(two.low), np.isnan(two.high)) == (2.0, True, True)
    assert 1.0 <= three.low < three.value < three.high <= 3.0


@pytest.mark.parametrize("count", [3, 4, 5])
def test_an_interval_of_few_values_covers_the_median_as_often_as_its_level_says(count: int) -> None:
    """The ends lie within the values, all of which are on one side of the median in 2 · 2⁻ᵏ of all cases."""
    held, draws = 0, 400
    for seed in range(draws):
        found = iqm_interval(np.random.default_rng(seed).normal(size=count), 0.95, 1000, seed)
        held += found.low <= 0.0 <= found.high
    claimed = level(0.95, count)
    assert claimed == 1.0 - 2.0 * 0.5**count
    assert held / draws == pytest.approx(claimed, abs=0.05)  # two standard errors; 0.95 is further off but of five
    assert (level(0.95, 6), level(0.5, 3)) == (0.95, 0.5)


def test_the_level_that_is_stated_is_that_of_the_fewest_values_with_an_interval() -> None:
    evaluator = SnapshotsEvaluator(episodes=1, confidence=0.95, resamples=10, seed=0)
    assert evaluator.stated(10, 30) == "95 %"
    assert evaluator.stated(10, 4, 3) == "75 % at most, of 3 values"
    assert evaluator.stated(2) == "95 %"  # has no interval


def test_two_curves_have_no_band() -> None:
    curves = np.array([[1.0, 5.0], [3.0, 7.0], [2.0, 6.0]])
    two, three = (iqm_band(curves[:k], 0.95, 500, 0) for k in (2, 3))
    np.testing.assert_array_equal(two, [[2.0, 6.0], [np.nan] * 2, [np.nan] * 2])
    assert (three[1] < three[0]).all()
    assert (three[0] < three[2]).all()


def test_the_probability_of_improvement_is_that_of_mann_and_whitney() -> None:
    ours, theirs = np.array([3.0, 1.0, 4.0, 1.5, np.nan]), np.array([2.0, 7.0, 1.0, 9.0])
    found = improvement_interval(ours, theirs, 0.95, 500, 0)
    assert found.value == pytest.approx(mannwhitneyu(ours[:4], theirs).statistic / 16)
    assert found.low < found.value < found.high
    assert np.isnan(improvement_interval(ours, theirs[:0], 0.95, 500, 0).value)


def test_all_of_ours_above_all_of_theirs_is_no_certainty() -> None:
    """Four pairs that are all ordered: with probability p⁴ at most, which is 1 − confidence at the end."""
    low, high = np.array([1.0, 2.0, 3.0, 4.0]), np.array([5.0, 6.0, 7.0, 8.0, 9.0])
    better, worse = (improvement_interval(*each, 0.95, 500, 0) for each in ((high, low), (low, high)))
    assert (better.value, better.high, worse.value, worse.low) == (1.0, 1.0, 0.0, 0.0)
    assert better.low**4 == pytest.approx(0.05)
    assert worse.high == pytest.approx(1.0 - better.low)
    nearly = improvement_interval(np.array([3.5, 6.0, 7.0, 8.0, 9.0]), low, 0.95, 500, 0)
    assert nearly.value < 1.0
    assert nearly.low <= better.low  # where ours are less surely better, so is the interval


@pytest.mark.parametrize("probability", [0.8, 0.97])
def test_the_interval_of_the_probability_holds_it_as_often_as_it_says(probability: float) -> None:
    """Two Gaussians a distance √2 Φ⁻¹(p) apart."""
    apart, held = np.sqrt(2.0) * norm.ppf(probability), 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        found = improvement_interval(rng.normal(apart, 1.0, 5), rng.normal(0.0, 1.0, 5), 0.95, 200, seed)
        held += found.low <= probability <= found.high
    assert held >= 0.95 * 200


@pytest.mark.parametrize(
    ("ours", "theirs", "enough"), [(1, 9, False), (2, 2, False), (3, 3, False), (4, 3, False), (4, 4, True)]
)
def test_few_results_have_a_probability_without_an_interval(ours: int, theirs: int, enough: bool) -> None:
    """All of one above all of the other: by chance 2/10, 1/3, 1/10, 2/35, 1/35."""
    found = improvement_interval(np.linspace(2.0, 3.0, ours), np.linspace(0.0, 1.0, theirs), 0.95, 100, 0)
    assert found.value == 1.0
    assert np.isfinite(found.low) == enough


def test_the_lower_tail_takes_its_share_exactly() -> None:
    assert lower_tail(np.append(np.arange(20.0), np.nan), 0.1) == 0.5
    assert lower_tail(np.arange(15.0), 0.1) == pytest.approx((0.0 + 0.5 * 1.0) / 1.5)
    assert lower_tail(np.array([3.0, 5.0]), 0.1) == pytest.approx(3.0)
    assert np.isnan(lower_tail(np.array([np.nan]), 0.1))


def test_a_context_returns_the_mean_of_its_episodes_unless_all_are_infeasible() -> None:
    returns = np.array([[4.0, -10.0], [-10.0, -10.0], [1.0, 2.0]])
    infeasible = np.array([[False, True], [True, True], [False, False]])
    np.testing.assert_array_equal(means_of_contexts(returns, infeasible), [-3.0, np.nan, 1.5])
