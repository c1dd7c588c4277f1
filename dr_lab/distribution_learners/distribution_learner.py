"""The contract of a distribution learner: what shapes p_φ(z) while a policy trains on it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

from tensordict import TensorDict

from dr_lab.collectors.experience import Experience
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.recorders.training import Comparison


class DistributionLearner(ABC):
    """Changes the parameters φ of a randomizer while a policy is trained.

    It computes on the CPU, on whatever device the policy learns: its few parameters and small networks gain nothing
    from another, and what it learns from is played there.

    Attributes:
        randomizer: p_φ(z), from which the environment draws.
        every: control steps of training between two updates, which wait for an iteration to end.
        first: control steps of training before which nothing is learned.
    """

    every: int = 1
    first: int = 0

    def __init__(self, randomizer: Randomizer) -> None:
        self.randomizer = randomizer

    @property
    def source(self) -> ContextSource:
        """Where training takes its contexts from: the randomizer, unless the learner proposes them slot by slot."""
        return self.randomizer

    @property
    def learns(self) -> bool:
        """Whether the distribution can change, so that pictures follow it."""
        return any(True for _ in self.randomizer.parameters())

    @abstractmethod
    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """Update φ.

        Args:
            batch: the newest, size [n, steps], as a collector gives it; the policy has not learnt from it yet.
            experience: plays the present policy, `experience.policy`, or any other, in contexts of one's choice.

        Returns:
            Figures to be recorded, by name.
        """

    def compared(self) -> Sequence[Comparison]:
        """What updates since the last call compared, for pictures, one entry a quantity; by default nothing is."""
        return ()

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"randomizer": self.randomizer.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.randomizer.load_state_dict(state["randomizer"])

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Begin with the distribution that another run's `state_dict` holds; all else is this run's own."""
        self.randomizer.load_state_dict(state["randomizer"])
