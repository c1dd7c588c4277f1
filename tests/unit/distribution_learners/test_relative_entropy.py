"""Weights against the dual that they solve, and a Gaussian whose step keeps its bound whatever the samples."""

from typing import Any

import numpy as np
import pytest
import torch
from scipy.optimize import minimize_scalar
from scipy.special import logsumexp
from torch.distributions import MultivariateNormal, kl_divergence

from dr_lab.distribution_learners.simopt.relative_entropy import (
    Gaussian,
    bounded_fit,
    sample_weights,
    temperature,
)
from dr_lab.trajectory import Array

LEAST = 1e-3


def entropy_lost(weight: Array) -> float:
    """KL(w‖uniform)."""
    return float(np.sum(weight * np.log(weight * len(weight))))


@pytest.mark.parametrize(("scale", "epsilon"), [(1.0, 0.5), (1e-2, 1.0), (1e6, 2.0)])
def test_the_temperature_solves_the_dual(scale: float, epsilon: float) -> None:
    costs = scale * np.random.default_rng(0).chisquare(3, 200)

    def dual(log_eta: float) -> float:
        eta = np.exp(log_eta)
        return eta * epsilon + eta * (logsumexp(-costs / eta) - np.log(len(costs)))

    eta = temperature(costs, epsilon, LEAST * scale)
    assert entropy_lost(sample_weights(costs, eta)) == pytest.approx(epsilon, rel=1e-6)
    best: Any = minimize_scalar(dual, bounds=(np.log(LEAST * scale), np.log(100 * scale)), method="bounded")
    assert dual(float(np.log(eta))) <= best.fun + 1e-9 * abs(best.fun)


def test_no_temperature_is_below_the_least() -> None:
    assert temperature(np.array([1.0, 1.0, 1.0]), 0.1, LEAST) == LEAST
    np.testing.assert_allclose(sample_weights(np.array([1.0, 1.0]), LEAST), 0.5)
    apart = sample_weights(np.array([0.0, 1e9]), LEAST)
    np.testing.assert_array_equal(apart, [1.0, 0.0])


def divergence(new: Gaussian, old: Gaussian) -> float:
    """KL(new‖old) by torch; ∞ where the new one is singular."""
    if np.linalg.matrix_rank(new.covariance / np.sqrt(np.outer(*2 * [np.diag(old.covariance)]))) < len(new.mean):
        return np.inf
    first, second = (
        MultivariateNormal(torch.from_numpy(each.mean), torch.from_numpy(each.covariance), validate_args=False)
        for each in (new, old)
    )
    return float(kl_divergence(first, second))


def random_problem(seed: int) -> tuple[Gaussian, Array, Array]:
    """A Gaussian in units far apart, and samples of it with weights that one or many of them carry."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 8))
    factor = np.diag(10.0 ** rng.uniform(-5, 3, n)) @ (np.tril(rng.normal(size=(n, n)), -1) + np.eye(n))
    old = Gaussian(rng.normal(size=n), factor @ factor.T)
    count = int(rng.integers(2, 60))
    z = old.mean + rng.normal(size=(count, n)) @ factor.T
    return old, z, rng.dirichlet(np.full(count, 10.0 ** rng.uniform(-2, 1)))


@pytest.mark.parametrize("epsilon", [1e-3, 0.1, 1.0, 5.0])
def test_no_step_exceeds_its_bound(epsilon: float) -> None:
    bounded = 0
    for seed in range(100):
        old, z, weight = random_problem(seed)
        new = bounded_fit(old, z, weight, epsilon)
        assert divergence(new, old) <= epsilon + 1e-6
        mean, away = weight @ z, z - weight @ z
        fitted = Gaussian(mean, (away.T * weight) @ away)
        if divergence(fitted, old) <= epsilon:
            np.testing.assert_allclose(new.mean, fitted.mean)
            np.testing.assert_allclose(new.covariance, fitted.covariance, rtol=1e-6, atol=1e-12 * old.covariance.max())
        else:
            assert divergence(new, old) == pytest.approx(epsilon, rel=1e-5)
            bounded += 1
    assert bounded > 10


def test_the_optimum_of_a_quadratic_is_found_within_ten_updates() -> None:
    rng, target = np.random.default_rng(0), np.array([3.0, -2.0])
    curvature = np.array([[2.0, 0.6], [0.6, 0.5]])
    now = Gaussian(np.zeros(2), np.eye(2))
    for _ in range(10):
        z = rng.multivariate_normal(now.mean, now.covariance, 200)
        costs = np.einsum("ki,ij,kj->k", z - target, curvature, z - target)
        old, now = now, bounded_fit(now, z, sample_weights(costs, temperature(costs, 1.0, 1e-9)), 1.0)
        assert divergence(now, old) <= 1.0 + 1e-6
    np.testing.assert_allclose(now.mean, target, atol=0.02)
