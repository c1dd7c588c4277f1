"""The contract of a distribution learner: what shapes p_φ(z) while a policy trains on it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Protocol

from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.trajectory import Array


class Rollouts(Protocol):
    """Episodes of the present policy in contexts of the learner's choice."""

    def returns(self, z: Array) -> Array:
        """Undiscounted return of an episode in each context (k, n), shape (k,); NaN where the context is infeasible."""
        ...


class DistributionLearner(ABC):
    """Changes the parameters φ of a randomizer while a policy is trained.

    Attributes:
        randomizer: p_φ(z), from which the environment draws.
        every: control steps of training between two updates, which wait for an iteration to end.
    """

    every: int = 1

    def __init__(self, randomizer: Randomizer) -> None:
        self.randomizer = randomizer

    @abstractmethod
    def update(self, rollouts: Rollouts) -> Mapping[str, float]:
        """Update φ.

        Args:
            rollouts: plays the present policy.

        Returns:
            Figures to be recorded, by name.
        """

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"randomizer": self.randomizer.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.randomizer.load_state_dict(state["randomizer"])
