"""Rewards that only depend on how far a machine is from where it should be, and on the effort."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dr_lab.trajectory import Array


class ErrorReward(ABC):
    """A reward of the error e = state − target and the action a."""

    @abstractmethod
    def __call__(self, error: Array, action: Array) -> Array:
        """Reward of n states.

        Args:
            error: positions, then velocities, angles within ±π, shape (n, k).
            action: shape (n, nu).
        """


@dataclass(frozen=True, kw_only=True)
class ExponentialReward(ErrorReward):
    """exp(−eᵀ Q e − aᵀ R a), between 0 and 1.

    Attributes:
        error_weights: diagonal of Q, shape (k,).
        action_weights: diagonal of R, shape (nu,).
    """

    error_weights: Sequence[float]
    action_weights: Sequence[float]

    def __call__(self, error: Array, action: Array) -> Array:
        """The reward."""
        return np.exp(-np.square(error) @ np.array(self.error_weights) - np.square(action) @ self.action_weights)


@dataclass(frozen=True, kw_only=True)
class QuadraticReward(ErrorReward):
    """−eᵀ Q e − aᵀ R a.

    Attributes:
        error_weights: diagonal of Q, shape (k,).
        action_weights: diagonal of R, shape (nu,).
    """

    error_weights: Sequence[float]
    action_weights: Sequence[float]

    def __call__(self, error: Array, action: Array) -> Array:
        """The reward."""
        return -np.square(error) @ np.array(self.error_weights) - np.square(action) @ self.action_weights


@dataclass(frozen=True, kw_only=True)
class SharedReward(ErrorReward):
    """Σᵢ wᵢ (1 − |xᵢ| / sᵢ)² over the errors and actions x, within [0, 1]; 0 where one of them reaches its limit.

    Attributes:
        weights: w of the errors, then of the actions, shape (k + nu,).
        scales: s, in their units.
        limits: in their units; ``inf`` where there is none.
    """

    weights: Sequence[float]
    scales: Sequence[float]
    limits: Sequence[float]

    def __call__(self, error: Array, action: Array) -> Array:
        """The reward."""
        size = np.abs(np.concatenate([error, action], axis=1))
        reward = np.square(1.0 - size / self.scales) @ np.array(self.weights)
        return np.where((size < self.limits).all(1), np.clip(reward, 0.0, 1.0), 0.0)
