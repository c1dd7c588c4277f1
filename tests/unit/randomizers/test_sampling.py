"""Draws of every randomizer follow its density, stream by stream."""

from collections.abc import Callable
from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from randomizer_samples import SPACE, correlated, factored, mixed, truncated, uneven, uniform
from scipy.stats import kstest, multivariate_normal, norm, truncnorm
from torch import Tensor

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.discrete import DiscreteRandomizer
from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.randomizers.gaussian import gaussian
from dr_lab.randomizers.histogram import Histogram
from dr_lab.randomizers.mixture import MixtureRandomizer
from dr_lab.randomizers.product import ProductRandomizer
from dr_lab.randomizers.randomizer import Density
from dr_lab.randomizers.truncated_normal import TruncatedNormalRandomizer
from dr_lab.randomizers.uniform import UniformRandomizer

MASS = ContextSpace(SPACE.parameters[:1])
DENSITIES = [correlated, uneven, mixed, uniform, truncated, factored]


@pytest.mark.parametrize("make", DENSITIES)
def test_draws_follow_the_density(make: Callable[[], Density]) -> None:
    randomizer = make()
    z = randomizer.sample([np.random.default_rng(0)] * 10_000)
    # E_p[f] over the draws equals ∫ f p over a fine grid: f = mean, second moments.
    steps = 300
    axes = [np.linspace(low, high, steps) for low, high in ((-0.5, 3.5), (-1.5, 1.5))]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)
    density = randomizer.log_prob(torch.from_numpy(grid)).exp().detach().numpy()
    weights = density * np.prod([axis[1] - axis[0] for axis in axes])
    assert weights.sum() == pytest.approx(1.0, abs=0.01)
    mean = weights @ grid
    np.testing.assert_allclose(z.mean(0), mean, atol=0.02)
    expected = (grid - mean).T @ ((grid - mean) * weights[:, None])
    np.testing.assert_allclose(np.cov(z.T), expected, atol=0.02)


@pytest.mark.parametrize("make", [*DENSITIES, lambda: FixedRandomizer(SPACE, {})])
def test_a_streams_draws_do_not_depend_on_the_others(make: Callable[[], Density]) -> None:
    randomizer = make()
    together = randomizer.sample([np.random.default_rng(seed) for seed in range(4)])
    alone = [randomizer.sample([np.random.default_rng(seed)])[0] for seed in range(4)]
    np.testing.assert_array_equal(together, alone)
    assert together.dtype == np.float64
    assert randomizer.sample([]).shape == (0, 2)


@pytest.mark.parametrize("make", [correlated, uneven, mixed, truncated, factored])
def test_gradient_of_the_log_density_by_finite_differences(make: Callable[[], Density]) -> None:
    randomizer = make()
    z = torch.from_numpy(uniform().sample([np.random.default_rng(1)] * 5))
    parameters = list(randomizer.parameters())
    gradient = torch.autograd.grad(randomizer.log_prob(z).sum(), parameters)
    step = 1e-6
    with torch.no_grad():
        for parameter, slope in zip(parameters, gradient, strict=True):
            for index in np.ndindex(parameter.shape):
                parameter[index] += step
                above = randomizer.log_prob(z).sum()
                parameter[index] -= 2 * step
                below = randomizer.log_prob(z).sum()
                parameter[index] += step
                assert slope[index].item() == pytest.approx((above - below).item() / (2 * step), abs=1e-6)


def test_a_gaussian_keeps_mean_and_covariance() -> None:
    normal = correlated().distribution()
    np.testing.assert_allclose(normal.mean.detach(), [1.4, 0.2])
    np.testing.assert_allclose(normal.covariance_matrix.detach(), [[0.09, -0.03], [-0.03, 0.04]], atol=1e-9)


def test_a_gaussian_moves_to_given_moments() -> None:
    randomizer = correlated()
    mean, covariance = np.array([0.9, -0.1]), np.array([[0.04, 0.01], [0.01, 0.09]])
    randomizer.set_moments(mean, covariance)
    normal = randomizer.distribution()
    np.testing.assert_allclose(normal.mean.detach(), mean)
    np.testing.assert_allclose(normal.covariance_matrix.detach(), covariance, atol=1e-9)
    z = np.array([[1.0, 0.0], [2.0, -0.5]])
    expected = multivariate_normal.logpdf(z, mean, cast(Any, covariance))
    np.testing.assert_allclose(randomizer.log_prob(torch.from_numpy(z)).detach(), expected, rtol=1e-6)


@pytest.mark.parametrize(("mean", "std"), [(1.2, 0.4), (2.4, 2.0), (5.0, 0.2), (-8.0, 0.5)])
def test_a_truncated_normal_is_that_of_scipy(mean: float, std: float) -> None:
    randomizer = TruncatedNormalRandomizer(MASS, {"mass": mean}, {"mass": std}, relative_std=1.0)
    low, high = MASS.low[0], MASS.high[0]
    expected: Any = truncnorm((low - mean) / std, (high - mean) / std, mean, std)
    inside = np.linspace(low, high, 9)[1:-1]
    np.testing.assert_allclose(
        randomizer.log_prob(torch.from_numpy(inside[:, None])).detach(), expected.logpdf(inside), rtol=1e-7
    )
    assert randomizer.log_prob(torch.tensor([[low - 0.1], [high + 0.1]])).tolist() == [-np.inf, -np.inf]
    draws = randomizer.sample([np.random.default_rng(0)] * 20_000)[:, 0]
    assert draws.mean() == pytest.approx(expected.mean(), abs=4 * expected.std() / np.sqrt(20_000))
    assert draws.std() == pytest.approx(expected.std(), rel=0.03)
    assert kstest(draws, expected.cdf).pvalue > 1e-3


def test_a_product_is_made_of_independent_families() -> None:
    randomizer = factored()
    z = np.array([[1.2, 0.1], [0.7, -0.6]])
    expected = norm.logpdf(z[:, 0], 1.4, 0.3) - np.log(2.0)
    np.testing.assert_allclose(randomizer.log_prob(torch.from_numpy(z)).detach(), expected, rtol=1e-6)
    draws = randomizer.sample([np.random.default_rng(0)] * 20_000)
    np.testing.assert_allclose(draws.mean(0), [1.4, 0.0], atol=0.02)
    np.testing.assert_allclose(np.cov(draws.T), [[0.09, 0.0], [0.0, 1 / 3]], atol=0.01)
    names = [name for name, _ in randomizer.named_parameters()]
    assert names == [f"factors.0.{name}" for name in ("loc", "log_diagonal", "lower")]
    with pytest.raises(ConfigError, match=r"each parameter at most once, for all but one of the factors a, b"):
        ProductRandomizer(SPACE, {"a": uniform, "b": uniform}, {})


def test_cells_are_cumulated_anew_where_their_logits_have_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Tensor] = []

    class Counted(Histogram):
        @property
        def log_probabilities(self) -> Tensor:  # pyright: ignore[reportIncompatibleVariableOverride]
            asked.append(self.logits)
            return self.logits.flatten().log_softmax(0).reshape(self.logits.shape)

    monkeypatch.setattr("dr_lab.randomizers.discrete.Histogram", Counted)
    randomizer, draw = DiscreteRandomizer(MASS, {}, bins=2), partial(np.random.default_rng, 0)
    drawn = [randomizer.sample([draw()] * 50) for _ in range(3)]
    assert len(asked) == 1
    np.testing.assert_array_equal(drawn[0], drawn[2])
    with torch.no_grad():
        randomizer.logits[0] -= 50.0  # as a step of an optimiser does, in place
    assert (randomizer.sample([draw()] * 50) >= MASS.low + MASS.span / 2).all()
    assert len(asked) == 2


def test_a_factor_may_have_no_parameter() -> None:
    """As two of the three in ``randomizer=product`` until they are given some."""
    families = {"normal": partial(gaussian, mean={}, std={}, relative_std=1.0, clip=False), "uniform": uniform}
    spread = ProductRandomizer(SPACE, families, {"normal": []})
    z = torch.tensor([[1.2, 0.1], [0.7, -0.6]], dtype=torch.float64)
    np.testing.assert_allclose(spread.log_prob(z), uniform().log_prob(z))
    assert ProductRandomizer(ContextSpace(()), {"normal": families["normal"]}, {}).log_prob(z[:, :0]).tolist() == [0, 0]


def test_a_gaussian_begins_in_the_centre_with_a_share_of_the_uniform_width() -> None:
    randomizer = gaussian(SPACE, {"mass": 2.0}, {"mass": 0.1}, relative_std=0.1, clip=False)
    normal = randomizer.distribution()
    np.testing.assert_allclose(normal.mean.detach(), [2.0, 0.0])
    np.testing.assert_allclose(normal.stddev.detach(), [0.1, 0.1 * 2 / np.sqrt(12)], rtol=1e-6)


def test_clipped_draws_stay_within_the_bounds() -> None:
    rngs = [np.random.default_rng(0)] * 200
    wide = gaussian(SPACE, {}, {}, relative_std=3.0, clip=True).sample(rngs)
    assert (wide >= SPACE.low).all()
    assert (wide <= SPACE.high).all()
    assert (wide == SPACE.low).any()


def test_fixed_gives_the_named_values_and_the_nominal_rest() -> None:
    randomizer = FixedRandomizer(SPACE, {"mass": 2.0})
    z = randomizer.sample([np.random.default_rng(0)] * 3)
    np.testing.assert_array_equal(z, [[2.0, 0.0]] * 3)
    assert randomizer.log_prob(torch.from_numpy(z)).tolist() == [0.0] * 3


def test_mistakes_are_told() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'friction'"):
        UniformRandomizer(SPACE, {"frction": [0.0, 1.0]})
    with pytest.raises(ConfigError, match="low < high"):
        UniformRandomizer(SPACE, {"mass": [2.0, 1.0]})
    with pytest.raises(ConfigError, match=r"ranges\.mass is \[1\.0, inf\] kg; expected finite"):
        UniformRandomizer(SPACE, {"mass": [1.0, np.inf]})
    for std in (np.inf, np.nan, -1.0):
        with pytest.raises(ConfigError, match=rf"randomizer\.std\.mass is {std:g}; expected a finite standard"):
            gaussian(SPACE, None, {"mass": std}, 1.0, clip=False)
        with pytest.raises(ConfigError, match=rf"randomizer\.relative_std is {std:g}; expected a finite standard"):
            TruncatedNormalRandomizer(SPACE, None, None, std)
    for value in (np.inf, np.nan):
        with pytest.raises(ConfigError, match=rf"randomizer\.mean\.mass is {value:g}; expected a finite number"):
            gaussian(SPACE, {"mass": value}, None, 1.0, clip=False)
        with pytest.raises(ConfigError, match=rf"mass of the context is {value:g}; expected a finite number"):
            FixedRandomizer(SPACE, {"mass": value})
        with pytest.raises(ConfigError, match="expected a finite number above 0 for each"):
            MixtureRandomizer(SPACE, {"narrow": correlated}, {"narrow": value})
    with pytest.raises(ConfigError, match="fewer bins"):
        DiscreteRandomizer(SPACE, {}, bins=5000)
    with pytest.raises(ConfigError, match="for each of the components narrow"):
        MixtureRandomizer(SPACE, {"narrow": correlated}, {"wide": 1.0})


@pytest.mark.parametrize(("std", "relative"), [({"mass": -0.1}, 0.1), ({}, -0.5)])
def test_a_negative_standard_deviation_is_refused(std: dict[str, float], relative: float) -> None:
    with pytest.raises(ConfigError, match=r"randomizer\.(std\.mass is -0\.1|relative_std is -0\.5); expected"):
        gaussian(SPACE, {}, std, relative_std=relative, clip=False)


@pytest.mark.parametrize("clip", [False, True])
def test_the_picture_of_a_known_density_is_exact(clip: bool) -> None:
    makers = [
        lambda: UniformRandomizer(SPACE, None),
        lambda: gaussian(SPACE, None, None, 1.5, clip),
        lambda: TruncatedNormalRandomizer(SPACE, None, None, 1.5),
    ]
    for randomizer in (make() for make in makers):
        for axis in range(2):
            exact = randomizer.marginal(axis)
            drawn = Density.shares(randomizer, axis, randomizer.edges(axis))  # by counting 4000 draws
            assert exact.shape == drawn.shape
            assert exact.sum() == pytest.approx(1.0)
            np.testing.assert_allclose(
                np.cumsum(exact), np.cumsum(drawn), atol=1.95 / np.sqrt(4000)
            )  # Kolmogorov, 0.1 %


def test_a_uniform_density_is_level() -> None:
    randomizer = UniformRandomizer(SPACE, None)
    share = randomizer.marginal(0)
    assert {*share.round(12).tolist()} == {0.0, round(1 / 60, 12)}
    mean, covariance = randomizer.moments()
    np.testing.assert_allclose(mean, (SPACE.low + SPACE.high) / 2)
    np.testing.assert_allclose(covariance, np.diag(SPACE.span**2 / 12))


def test_pictures_of_a_mixture_are_its_components_by_their_weights() -> None:
    middle = float(SPACE.low[0] + SPACE.span[0] / 2)
    halves = {"low": [float(SPACE.low[0]), middle], "high": [middle, float(SPACE.high[0])]}
    box = {name: partial(UniformRandomizer, ranges={SPACE.names[0]: ends}) for name, ends in halves.items()}
    mixed = MixtureRandomizer(SPACE, box, {"low": 3.0, "high": 1.0})
    edges = np.array([SPACE.low[0], middle, SPACE.high[0]])
    np.testing.assert_allclose(mixed.shares(0, edges), [0.75, 0.25])
