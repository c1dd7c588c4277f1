"""Cosines of noisy gradients: known angles are recovered, and noise is told from interference."""

import numpy as np
import pytest

from dr_lab.evaluators.cosines import Cosines, cosines
from dr_lab.trajectory import Array

WIDTH = 20
MEAN = np.zeros(WIDTH)
MEAN[0] = 1.0


def episodes(mean: Array, count: int, noise: float, seed: int) -> Array:
    return mean + noise * np.random.default_rng(seed).normal(size=(count, WIDTH))


def compared(*gradients: Array, resamples: int = 300) -> Cosines:
    return cosines(gradients, confidence=0.95, resamples=resamples, seed=0)


def test_gradients_without_noise_have_the_cosine_of_their_angle() -> None:
    turned = np.zeros(WIDTH)
    turned[:2] = np.cos(2.0), np.sin(2.0)
    found = compared(*(np.tile(mean, (5, 1)) for mean in (MEAN, 3.0 * turned, -MEAN)))
    wanted = np.array([[1.0, np.cos(2.0), -1.0], [np.cos(2.0), 1.0, -np.cos(2.0)], [-1.0, -np.cos(2.0), 1.0]])
    for matrix in (found.raw, found.corrected):
        np.testing.assert_allclose(matrix, wanted, atol=1e-12)
    for end in (found.low, found.high):
        np.testing.assert_allclose(end, np.where(np.eye(3), np.nan, wanted), atol=1e-12)
    assert found.sign.tolist() == [[1, -1, -1], [-1, 1, 1], [-1, 1, 1]]


def test_the_diagonal_is_a_cosine_also_where_there_is_noise_alone() -> None:
    own = [compared(np.random.default_rng(seed).normal(size=(4, 3)), resamples=1).raw[0, 0] for seed in range(50)]
    assert min(own) == -1.0  # halves of a few episodes that sum to almost nothing point away from one another
    assert max(own) <= 1.0


@pytest.mark.slow
def test_noise_shrinks_cosines_and_the_correction_undoes_it() -> None:
    # ‖ḡ‖² = 1 + 20·6.25/100 = 2.25, so that a cosine of 1 is seen as 1/2.25 on average.
    found = [compared(*(episodes(MEAN, 100, 2.5, 10 * seed + k) for k in range(3)), resamples=1) for seed in range(20)]
    raw = np.array([each.raw for each in found])
    pairs, own = raw[:, *np.triu_indices(3, 1)], np.diagonal(raw, axis1=1, axis2=2)
    assert pairs.mean() == pytest.approx(1 / 2.25, abs=0.04)
    assert own.mean() == pytest.approx(pairs.mean(), abs=0.04)  # the diagonal is what a pair is to be compared with
    strong = [
        compared(*(episodes(MEAN, 200, 1.0, 10 * seed + k) for k in range(2)), resamples=20) for seed in range(20)
    ]
    assert np.mean([each.raw[0, 1] for each in strong]) == pytest.approx(1 / 1.1, abs=0.02)  # 1 + 20·1/200
    assert np.mean([each.corrected[0, 1] for each in strong]) == pytest.approx(1.0, abs=0.02)


def test_the_same_gradient_is_one_within_its_interval_and_the_opposite_minus_one() -> None:
    hits = np.zeros(3)
    for seed in range(20):
        means = (MEAN, MEAN, -MEAN)
        found = compared(*(episodes(mean, 100, 1.0, 10 * seed + k) for k, mean in enumerate(means)))
        wanted = np.array([1.0, -1.0, -1.0])
        pairs = np.triu_indices(3, 1)
        hits += (found.low[pairs] <= wanted) & (wanted <= found.high[pairs])
        assert found.sign[pairs].tolist() == wanted.tolist()
    assert (hits / 20 > 0.85).all()


def test_noise_alone_is_neither_interference_nor_transfer() -> None:
    doubtful, told = list[float](), list[float]()
    for seed in range(20):
        found = compared(*(episodes(0.0 * MEAN, 30, 1.0, 10 * seed + k) for k in range(5)))
        doubtful.append(float(np.mean(found.sign[np.triu_indices(5, 1)] == 0)))
        told.append(float(np.mean(np.isfinite(np.diagonal(found.corrected)))))
    assert np.mean(doubtful) > 0.93
    assert np.mean(told) < 0.1


def test_a_context_with_too_few_episodes_stays_empty() -> None:
    found = compared(np.tile(MEAN, (4, 1)), np.empty((0, WIDTH)), np.tile(-MEAN, (4, 1)), np.tile(MEAN, (1, 1)))
    assert np.isnan(found.raw[[1, 3]]).all()
    assert np.isnan(found.corrected[:, [1, 3]]).all()
    assert found.raw[0, 2] == pytest.approx(-1.0)
    assert np.isnan(compared(np.empty((0, WIDTH))).raw).all()


def test_a_gradient_that_vanishes_has_no_cosine() -> None:
    found = compared(np.tile(MEAN, (4, 1)), np.zeros((4, WIDTH)))
    assert np.isnan(found.corrected[0, 1])
    assert np.isnan(found.raw[[0, 1], 1]).all()
    assert found.sign[0, 1] == 0
