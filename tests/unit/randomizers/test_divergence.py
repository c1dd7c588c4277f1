"""KL divergences in closed form agree with Monte Carlo and with what is known."""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
import torch
from randomizer_samples import SPACE, correlated, mixed, uneven, uniform

from dr_lab.randomizers.discrete import DiscreteRandomizer
from dr_lab.randomizers.divergence import divergence
from dr_lab.randomizers.gaussian import gaussian
from dr_lab.randomizers.randomizer import Density
from dr_lab.randomizers.uniform import UniformRandomizer

Make = Callable[[], Density]
RNG = np.random.default_rng(0)


def wide() -> Density:
    return UniformRandomizer(SPACE, {})


def off_grid() -> Density:
    return UniformRandomizer(SPACE, {"mass": [0.7, 1.9], "friction": [-0.9, 0.1]})


PAIRS = [
    *itertools.product([wide, off_grid, uniform, uneven], [uneven, correlated]),
    (correlated, lambda: gaussian(SPACE, {}, {}, 1.0, clip=False)),
    (uniform, wide),
]


@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_closed_forms_agree_with_monte_carlo(first: Make, second: Make) -> None:
    p, q = first(), second()
    closed = divergence(p, q, samples=0, rng=RNG)
    z = torch.from_numpy(p.sample([np.random.default_rng(1)] * 40_000))
    ratios = (p.log_prob(z) - q.log_prob(z)).detach()
    error = 4.0 * ratios.std().item() / np.sqrt(len(z)) + 1e-12
    assert closed.item() == pytest.approx(ratios.mean().item(), abs=error)


@pytest.mark.parametrize("make", [wide, uneven, correlated])
def test_no_divergence_from_itself(make: Make) -> None:
    assert divergence(make(), make(), samples=0, rng=RNG).item() == pytest.approx(0.0, abs=1e-12)


def test_uniform_to_uniform_cells_is_nothing_and_to_one_cell_is_infinite() -> None:
    cells = DiscreteRandomizer(SPACE, {}, bins=4)
    assert divergence(wide(), cells, samples=0, rng=RNG).item() == pytest.approx(0.0, abs=1e-12)
    assert divergence(wide(), DiscreteRandomizer(SPACE, {"mass": [0.5, 1.0]}, 4), samples=0, rng=RNG).isposinf()


def test_gradient_of_the_divergence_to_cells_is_their_excess() -> None:
    # ∂KL(p‖q)/∂logits = Q − P, P = 1/9 for the uniform p.
    cells = uneven()
    divergence(wide(), cells, samples=0, rng=RNG).backward()
    assert cells.logits.grad is not None
    expected = cells.distribution().log_probabilities.exp().detach() - 1 / 9
    np.testing.assert_allclose(cells.logits.grad, expected, atol=1e-12)


def test_a_mixture_takes_monte_carlo() -> None:
    p, q = mixed(), correlated()
    estimate = divergence(p, q, samples=4000, rng=np.random.default_rng(2))
    again = divergence(p, q, samples=4000, rng=np.random.default_rng(3))
    assert estimate.requires_grad
    assert estimate.item() > 0
    assert estimate.item() == pytest.approx(again.item(), rel=0.15)
