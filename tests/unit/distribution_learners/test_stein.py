"""Particles that climb and keep apart, against autograd and against densities that are known."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import torch
from scipy.stats import norm
from torch import Tensor

from dr_lab.distribution_learners.svpg.stein import ascent_direction, rbf

PEAKS = (-2.0, 2.0)


def bandwidth(x: Tensor) -> float:
    return float(torch.pdist(x).square().median()) / math.log(len(x) + 1)


@pytest.mark.parametrize("n", [2, 3, 7])
def test_the_repulsion_is_the_kernels_gradient_by_autograd(n: int) -> None:
    x = torch.randn(n, 5, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    h, kernel = bandwidth(x), rbf(x)
    for i in range(n):
        moved = x.clone().requires_grad_()
        values = (-(moved - x[i]).square().sum(1) / h).exp()  # k(xⱼ, xᵢ), xᵢ held fixed
        (gradient,) = torch.autograd.grad(values.sum(), moved)
        torch.testing.assert_close(kernel.values[:, i], values.detach())
        torch.testing.assert_close(kernel.repulsion[i], gradient.sum(0))


def test_the_direction_is_that_of_the_paper_written_out() -> None:
    draw = torch.Generator().manual_seed(1)
    x, gradient = (torch.randn(4, 3, dtype=torch.float64, generator=draw) for _ in range(2))
    h, expected = bandwidth(x), torch.zeros_like(x)
    for i in range(4):
        for j in range(4):
            k = torch.exp(-(x[j] - x[i]).square().sum() / h)
            expected[i] += (k * gradient[j] / 10.0 - (2.0 / h) * (x[j] - x[i]) * k) / 4
    torch.testing.assert_close(ascent_direction(x, gradient, 10.0), expected)


def test_a_single_particle_climbs_alone_and_two_that_coincide_stay_finite() -> None:
    x, gradient = torch.ones(1, 3), torch.full((1, 3), 2.0)
    torch.testing.assert_close(ascent_direction(x, gradient, 4.0), torch.full((1, 3), 0.5))
    assert ascent_direction(torch.ones(2, 3), torch.ones(2, 3), 1.0).tolist() == [[1.0] * 3] * 2


def moved(score: Callable[[Tensor], Tensor], temperature: float, steps: int = 800) -> np.ndarray:
    """Particles on a line after steps of Adam along φ, sorted."""
    x = torch.linspace(-1.5, 3.0, 30, dtype=torch.float64)[:, None].requires_grad_()
    adam = torch.optim.Adam([x], lr=0.1)
    for _ in range(steps):
        x.grad = -ascent_direction(x.detach(), score(x.detach()), temperature)
        adam.step()
    return np.sort(x.detach().numpy()[:, 0])


def test_quantiles_of_the_particles_are_those_of_the_density() -> None:
    mean, std = 1.5, 0.7
    expected = norm(mean, std).ppf((np.arange(30) + 0.5) / 30)
    # J/T = −(x − m)²/2s² with T = 2
    found = moved(lambda x: 2.0 * (mean - x) / std**2, temperature=2.0)
    np.testing.assert_allclose(found, expected, atol=0.2 * std)


def two_peaks(x: Tensor) -> Tensor:
    """Gradient of log Σ exp(−(x − m)²/2) over two peaks."""
    weights = torch.stack([-0.5 * (x - m) ** 2 for m in PEAKS]).softmax(0)
    return sum((w * (m - x) for w, m in zip(weights, PEAKS, strict=True)), torch.zeros_like(x))


def test_cold_particles_gather_on_the_peaks_and_hot_ones_spread() -> None:
    cold, warm, hot = (moved(two_peaks, temperature) for temperature in (1e-3, 1.0, 100.0))
    # The mixture's peaks lie slightly inside of ±2.
    assert np.abs(np.abs(cold) - 2.0).max() < 0.1
    assert {-1.0, 1.0} == set(np.sign(cold))
    assert np.ptp(cold) < np.ptp(warm) < np.ptp(hot)
    assert np.ptp(hot) > 20.0
