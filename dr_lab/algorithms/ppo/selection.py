"""Which control steps of a batch a policy learns from."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from torch import Tensor


class Selection(ABC):
    """Chooses among the control steps of a batch.

    Attributes:
        algorithm: what PPO is called that learns from what is chosen.

    Args:
        gamma: discount per control step.
    """

    algorithm: ClassVar[str] = "PPO"

    def __init__(self, gamma: float) -> None:
        self.gamma = gamma

    @abstractmethod
    def __call__(self, reward: Tensor, done: Tensor, infeasible: Tensor, next_value: Tensor) -> Tensor:
        """Which are learnt from, shape (n, steps).

        Args:
            reward: as the task gave it, shape (n, steps), as all that follows.
            done: whether the episode ended.
            infeasible: whether it ended because its context is infeasible.
            next_value: V of the episode's own next observation, in the unit of these rewards.
        """

    def begin_schedules(self) -> None:  # noqa: B027 (few have one)
        """Begin anew what changes from batch to batch."""

    def forget_episodes(self) -> None:  # noqa: B027 (few remember any)
        """New episodes begin: let go of what is known of those that go on."""

    @abstractmethod
    def state_dict(self) -> dict[str, Any]:
        """What is known of the episodes that go on."""

    @abstractmethod
    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""


class FeasibleSteps(Selection):
    """All but those at which an infeasible context ended an episode: no action led there or would lead out of it."""

    def __call__(self, reward: Tensor, done: Tensor, infeasible: Tensor, next_value: Tensor) -> Tensor:
        """True where the context is feasible."""
        del reward, done, next_value
        return ~infeasible

    def state_dict(self) -> dict[str, Any]:
        """Nothing."""
        return {}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Nothing."""
