"""The learned distribution as recordings show it."""

from collections.abc import Sequence

import numpy as np
import pytest
import torch
from randomizer_samples import SPACE, correlated, uneven
from scipy.stats import norm

from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.randomizers.gaussian import gaussian
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Comparison
from dr_lab.training.snapshots import Snapshots
from dr_lab.trajectory import Array


def test_marginals_of_a_grid_are_exact_and_follow_it() -> None:
    randomizer = uneven()
    snapshots = Snapshots(randomizer)
    snapshots.take(0)
    before = randomizer.distribution().log_probabilities.exp().detach()
    with torch.no_grad():
        randomizer.logits.zero_()
    snapshots.take(3)
    for axis, marginal in enumerate(snapshots.marginals()):
        np.testing.assert_allclose(marginal.initial, before.sum(1 - axis))
        np.testing.assert_allclose(marginal.probability, [before.sum(1 - axis).tolist(), [1 / 3] * 3])
        np.testing.assert_array_equal(marginal.iteration, [0, 3])
        assert (marginal.name, marginal.unit) == (SPACE.names[axis], SPACE.parameters[axis].unit)
        np.testing.assert_allclose(marginal.edges[[0, -1]], [SPACE.low[axis], SPACE.high[axis]])


def test_pairs_hold_mean_and_covariance() -> None:
    snapshots = Snapshots(correlated())
    snapshots.take(0)
    (pair,) = snapshots.pairs()
    assert pair.names == ("mass", "friction")
    np.testing.assert_allclose(pair.mean, [[1.4, 0.2]], atol=0.02)
    np.testing.assert_allclose(pair.covariance, [[[0.09, -0.03], [-0.03, 0.04]]], atol=0.01)
    marginal = snapshots.marginals()[0]
    middle = (marginal.edges[1:] + marginal.edges[:-1]) / 2
    np.testing.assert_allclose(marginal.probability @ middle, [1.4], atol=0.02)


def test_what_leaves_its_bounds_stays_in_the_picture() -> None:
    randomizer = correlated()
    snapshots = Snapshots(randomizer)
    snapshots.take(0)
    _, within = snapshots.marginals()  # by five standard deviations
    np.testing.assert_allclose(within.edges[[0, -1]], [SPACE.low[1], SPACE.high[1]])
    with torch.no_grad():
        randomizer.loc += (SPACE.high[0] - randomizer.distribution().mean[0]) / randomizer.width[0]
    snapshots.take(1)
    assert all(len(marginal.edges) == marginal.probability.shape[1] + 1 for marginal in snapshots.marginals())
    first = snapshots.marginals()[0]
    np.testing.assert_allclose(first.probability.sum(1), 1.0, atol=2e-3)
    (pair,) = snapshots.pairs()
    middle, std = pair.mean[1], np.sqrt(np.diagonal(pair.covariance[1]))
    assert pair.high[0] > middle[0] + 2.5 * std[0] > SPACE.high[0]
    below, above = first.edges[first.edges < middle[0]], first.edges[first.edges > middle[0]]
    mass = first.probability[1][: len(below)].sum(), first.probability[1][-len(above) :].sum()
    np.testing.assert_allclose(mass, 0.5, atol=0.05)


@pytest.mark.parametrize("std", [7e-4, 1e-5])
def test_bins_follow_a_spread_much_narrower_than_the_bounds(std: float) -> None:
    randomizer = gaussian(SPACE, {"mass": 1.4}, {"mass": std}, 1.0, clip=False)
    snapshots = Snapshots(randomizer)
    for iteration in range(3):
        snapshots.take(iteration)
        randomizer.set_moments(np.array([1.4 + std, 0.0]), randomizer.moments()[1])
    mass, friction = snapshots.marginals()
    assert np.ptp(mass.edges) < 20 * std
    assert "part of its bounds 0.5 to 2.5" in mass.title
    middle = (mass.edges[1:] + mass.edges[:-1]) / 2
    for at, probability in ((1.4, mass.initial), (1.4 + std, mass.probability[-1])):
        density = probability / np.diff(mass.edges)
        np.testing.assert_allclose(density, norm.pdf(middle, at, std), atol=0.03 / std)
    assert friction.title == "friction"
    assert friction.edges[0] <= SPACE.low[1] < SPACE.high[1] <= friction.edges[-1]


def test_a_spread_that_narrows_has_its_density_in_the_end() -> None:
    randomizer = gaussian(SPACE, {"mass": 1.4}, {"mass": 0.3}, 1.0, clip=False)
    snapshots = Snapshots(randomizer)
    snapshots.take(0)
    randomizer.set_moments(np.array([1.4, 0.0]), np.diag([1e-6, 1.0]))
    snapshots.take(1)
    mass = snapshots.marginals()[0]
    np.testing.assert_allclose(mass.probability.sum(1), 1.0, atol=2e-3)
    density = mass.probability / np.diff(mass.edges)
    assert density.max(1) == pytest.approx(norm.pdf(0.0, 0.0, [0.3, 1e-3]), rel=0.05)
    assert mass.bounds is None


def test_one_value_keeps_the_bins_over_the_bounds() -> None:
    snapshots = Snapshots(FixedRandomizer(SPACE, None))
    snapshots.take(0)
    for axis, marginal in enumerate(snapshots.marginals()):
        np.testing.assert_allclose(marginal.edges[[0, -1]], [SPACE.low[axis], SPACE.high[axis]])
        assert marginal.bounds is None


def test_what_tells_no_moments_has_marginals_and_no_pairs() -> None:
    class Particles(Randomizer):
        def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
            picked = [rng.integers(2) for rng in rngs]
            return np.array([[1.0, -0.5], [2.0, 0.5]])[picked]

        def moments(self) -> None:
            return None

    snapshots = Snapshots(Particles(SPACE))
    snapshots.take(0)
    assert snapshots.pairs() == []
    first, second = snapshots.marginals()
    assert np.count_nonzero(first.initial) == np.count_nonzero(second.initial) == 2
    np.testing.assert_allclose(first.initial[first.initial > 0], 0.5, atol=0.03)


def test_what_was_compared_stays_at_its_iteration() -> None:
    time = np.array([0.01, 0.02])
    seen = [Comparison("arm.position", "rad", time, time * k, time, np.zeros((3, 2))) for k in (1, 2)]
    first, second = Snapshots(correlated()), Snapshots(correlated())
    first.take(0)
    first.take(1, [seen[0]])
    second.load_state_dict(first.state_dict())
    second.take(2)
    second.take(3, [seen[1]])
    (arm,) = second.comparisons()
    assert arm.iteration.tolist() == [1, 3]
    np.testing.assert_array_equal([each.target for each in arm.shown], [time, 2 * time])
    mass, friction = second.spreads()
    np.testing.assert_allclose((mass.mean, mass.std), ([1.4] * 4, [0.3] * 4), rtol=1e-6)
    np.testing.assert_allclose((friction.mean, friction.std), ([0.2] * 4, [0.2] * 4), rtol=1e-6)
    assert Snapshots(uneven()).spreads() == []


def test_continues() -> None:
    first, second = Snapshots(uneven()), Snapshots(uneven())
    first.take(0)
    second.load_state_dict(first.state_dict())
    second.take(1)
    assert second.marginals()[0].iteration.tolist() == [0, 1]
