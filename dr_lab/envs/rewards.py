"""Rewards that only depend on how far a machine is from where it should be, and on the effort."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from dr_lab.bounds import FINITE, above, at_least, numbers, require_bounds
from dr_lab.errors import ConfigError
from dr_lab.reports.quantity import counted
from dr_lab.trajectory import Array

_Weights = Annotated[Sequence[float], numbers(None, at_least(0.0), FINITE)]
_Sizes = Annotated[Sequence[float], numbers(None, above(0.0), FINITE)]
_Limits = Annotated[Sequence[float], numbers(None, above(0.0))]


class ErrorReward(ABC):
    """A reward of the error e = state − target and the action a."""

    def lengths(self, errors: int, actions: int) -> Mapping[str, int]:
        """How many numbers each of its lists has to hold for so many errors and actions; unless it says so, any."""
        del errors, actions
        return {}

    def require_lengths(self, errors: int, actions: int, key: str) -> None:
        """Check that it fits a task.

        Args:
            errors: k, positions and velocities.
            actions: nu.
            key: where it stands in the configuration, for the message.

        Raises:
            ConfigError: a list has another length.
        """
        for name, count in self.lengths(errors, actions).items():
            given = list(getattr(self, name))
            if len(given) != count:
                raise ConfigError(
                    f"{key}.{name} is {given}; expected {counted(count, 'number')}, for a reward of "
                    f"{counted(errors, 'error')} and of {counted(actions, 'action')}."
                )

    @abstractmethod
    def __call__(self, error: Array, action: Array) -> Array:
        """Reward of n states.

        Args:
            error: positions, then velocities, angles within ±π, shape (n, k).
            action: shape (n, nu).
        """


@dataclass(frozen=True, kw_only=True)
class WeightedReward(ErrorReward):
    """A reward by the cost eᵀ Q e + aᵀ R a.

    Attributes:
        error_weights: diagonal of Q, shape (k,).
        action_weights: diagonal of R, shape (nu,).

    Raises:
        ConfigError: a weight is negative or not finite.
    """

    error_weights: _Weights
    action_weights: _Weights

    def __post_init__(self) -> None:
        require_bounds(self, "env.task.reward_of")

    def lengths(self, errors: int, actions: int) -> Mapping[str, int]:
        """A weight each."""
        return {"error_weights": errors, "action_weights": actions}

    def cost(self, error: Array, action: Array) -> Array:
        """The weighted squares of errors (n, k) and actions (n, nu), shape (n,)."""
        return np.square(error) @ np.array(self.error_weights) + np.square(action) @ np.array(self.action_weights)


class ExponentialReward(WeightedReward):
    """exp(−eᵀ Q e − aᵀ R a), between 0 and 1."""

    def __call__(self, error: Array, action: Array) -> Array:
        """The reward."""
        return np.exp(-self.cost(error, action))


class QuadraticReward(WeightedReward):
    """−eᵀ Q e − aᵀ R a."""

    def __call__(self, error: Array, action: Array) -> Array:
        """The reward."""
        return -self.cost(error, action)


@dataclass(frozen=True, kw_only=True)
class SharedReward(ErrorReward):
    """Σᵢ wᵢ (1 − |xᵢ| / sᵢ)² over the errors and actions x, within [0, 1]; 0 where one of them reaches its limit.

    Attributes:
        weights: w of the errors, then of the actions, shape (k + nu,).
        scales: s, in their units.
        limits: in their units; ``inf`` where there is none.

    Raises:
        ConfigError: a weight is negative, or a scale or a limit not above 0.
    """

    weights: _Weights
    scales: _Sizes
    limits: _Limits

    def __post_init__(self) -> None:
        require_bounds(self, "env.task.reward_of")

    def lengths(self, errors: int, actions: int) -> Mapping[str, int]:
        """A weight, a scale and a limit each."""
        return dict.fromkeys(("weights", "scales", "limits"), errors + actions)

    def __call__(self, error: Array, action: Array) -> Array:
        """The reward."""
        size = np.abs(np.concatenate([error, action], axis=1))
        reward = np.square(1.0 - size / self.scales) @ np.array(self.weights)
        return np.where((size < self.limits).all(1), np.clip(reward, 0.0, 1.0), 0.0)
