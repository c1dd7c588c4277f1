"""Relative entropy policy search: better samples weigh more, and the Gaussian that follows stays near the last one."""

from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import brentq
from scipy.special import softmax

from dr_lab.trajectory import Array

_HALVINGS = 50  # of an interval: ν to 15 digits


class Gaussian(NamedTuple):
    """N(μ, Σ): `mean` (n,) and `covariance` (n, n)."""

    mean: Array
    covariance: Array


def temperature(costs: Array, epsilon: float, least: float) -> float:
    """η that solves REPS' dual, min over η ≥ `least` of ηε + η log mean exp(−c/η).

    At the optimum the weights of the samples, w ∝ exp(−c/η), have the divergence KL(w‖uniform) = ε, which falls as η
    rises; where even at `least` it does not exceed ε, that is the optimum.

    Source: Peters, Mülling, Altün 2010, equation 10, without features.

    Args:
        costs: of the samples, finite, shape (k,).
        epsilon: ε, above 0.
        least: lowest η, above 0.
    """

    def beyond(log_eta: float) -> float:
        weight = sample_weights(costs, float(np.exp(log_eta)))
        known = weight[weight > 0.0]
        return float(known @ np.log(known * len(costs))) - epsilon

    low = float(np.log(least))
    if beyond(low) <= 0.0:
        return least
    high = low
    while beyond(high) > 0.0:
        high += 1.0
    return float(np.exp(cast(float, brentq(beyond, low, high, xtol=1e-12))))


def sample_weights(costs: Array, eta: float) -> Array:
    """exp(−c/η), which sum up to 1."""
    return softmax(-costs / eta)


def bounded_fit(old: Gaussian, z: Array, weight: Array, epsilon: float) -> Gaussian:
    """The Gaussian of greatest weighted likelihood for which KL(new‖old) ≤ ε holds.

    For a multiplier ν ≥ 0 the maximum of Σ w log q(z) − ν KL(old‖q) has the closed form

        μ = (Σ w z + ν μ₀) / (1 + ν),    Σ = (Σ w (z − μ)(z − μ)ᵀ + ν Σ₀ + ν (μ − μ₀)(μ − μ₀)ᵀ) / (1 + ν),

    which leads from the weighted samples at ν = 0 to the old Gaussian as ν → ∞. The smallest ν at which the bound
    holds is found by bisection between one at which it holds and one at which it does not. The bound of the sample
    weights alone does not give it: few samples scatter, and a covariance of fewer than n + 1 of them is singular.

    Args:
        old: with a regular covariance.
        z: samples, shape (k, n).
        weight: of each, shape (k,), of sum 1.
        epsilon: ε, above 0.
    """
    factor = np.linalg.cholesky(old.covariance)
    y: Array = solve_triangular(factor, (z - old.mean).T, lower=True).T  # in which the old Gaussian is N(0, I)
    found = _between(y, weight, _least_multiplier(lambda nu: _divergence(_between(y, weight, nu)), epsilon))
    return Gaussian(old.mean + factor @ found.mean, factor @ found.covariance @ factor.T)


def _between(y: Array, weight: Array, nu: float) -> Gaussian:
    share = 1.0 / (1.0 + nu)
    mean = share * (weight @ y)
    away = y - mean
    spread = share * (away.T * weight) @ away
    return Gaussian(mean, spread + (1.0 - share) * (np.eye(len(mean)) + np.outer(mean, mean)))


def _divergence(new: Gaussian) -> float:
    """KL(new‖N(0, I))."""
    sign, log_det = np.linalg.slogdet(new.covariance)
    if sign <= 0 or not np.isfinite(log_det):
        return float("inf")
    return 0.5 * float(np.trace(new.covariance) + new.mean @ new.mean - len(new.mean) - log_det)


def _least_multiplier(diverges: Callable[[float], float], epsilon: float) -> float:
    """Smallest ν at which a divergence that falls with ν is at most ε, from above: there the bound holds."""
    if diverges(0.0) <= epsilon:
        return 0.0
    high = 1.0
    while diverges(high) > epsilon:
        high *= 2.0
    low = high / 2.0
    while diverges(low) <= epsilon:
        low, high = low / 2.0, low
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if diverges(middle) <= epsilon else (middle, high)
    return high
