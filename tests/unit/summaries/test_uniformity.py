"""The test of counts against the uniform distribution."""

import numpy as np
import pytest
from scipy.stats import chisquare

from dr_lab.summaries.uniformity import uniformity


def test_of_one_block_it_is_pearsons_test() -> None:
    counts = np.array([[[12, 20, 8, 10]]])
    found = uniformity(counts)
    assert found is not None
    known = chisquare(counts[0, 0])
    assert (found.blocks, found.dof) == (1, 3)
    assert found.chi2 == pytest.approx(known.statistic)
    assert found.p == pytest.approx(known.pvalue)
    assert found.p_between is None  # of one run nothing is known of others


def test_blocks_add_up_and_those_with_few_draws_are_left_out() -> None:
    found = uniformity(np.array([[[15, 5], [5, 15], [1, 0]]]))
    assert found is not None
    assert (found.blocks, found.dof, found.chi2) == (2, 2, 10.0)  # together they would be uniform
    assert uniformity(np.array([[[5, 4]]])) is None


def test_uniform_draws_are_seldom_refused() -> None:
    rng = np.random.default_rng(0)
    found = [uniformity(rng.multinomial(50, np.full(10, 0.1), (5, 4))) for _ in range(200)]
    p = np.array([[each.p, each.p_between] for each in found if each is not None], float)
    assert len(p) == 200
    assert (np.mean(p < 0.05, axis=0) < 0.1).all()
    assert (np.abs(np.median(p, axis=0) - 0.5) < 0.1).all()


def test_what_each_run_prefers_by_itself_is_no_preference_of_all() -> None:
    """Draws that come in clumps of ten, as those of a walk do."""
    rng = np.random.default_rng(1)
    clumped = [uniformity(10 * rng.multinomial(10, np.full(5, 0.2), (6, 3))) for _ in range(100)]
    p = np.array([[each.p, each.p_between] for each in clumped if each is not None], float)
    assert np.mean(p[:, 0] < 0.05) > 0.9
    assert np.mean(p[:, 1] < 0.05) < 0.12
    alike = uniformity(10 * rng.multinomial(10, [0.05, 0.05, 0.1, 0.3, 0.5], (6, 3)))
    assert alike is not None
    assert alike.p_between is not None
    assert alike.p_between < 1e-6
