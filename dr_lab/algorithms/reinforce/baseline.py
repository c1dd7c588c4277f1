"""The contract of a baseline: what an episode returns on average, whatever action is taken."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import torch
from torch import Tensor

from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes


class Baseline(ABC):
    """b(o_t, t), which is taken off the returns-to-go so that the gradient scatters less.

    That of an episode comes from other episodes alone, so that it depends on none of the episode's actions and leaves
    the gradient's expectation as it is. Most come from the same batch and keep nothing; one that learns from batch to
    batch has learnt from earlier ones.

    Attributes:
        learns: whether it is nothing until it has learnt from a batch.
    """

    learns: ClassVar[bool] = False

    @abstractmethod
    def __call__(self, episodes: WholeEpisodes, to_go: Tensor) -> Tensor:
        """Baseline of every step, shape (k, t); what it is beyond an episode's end has no meaning.

        A pure function, which `torch.vmap` takes over many tasks at once.

        Args:
            episodes: k, independent of one another.
            to_go: their returns-to-go, shape (k, t).
        """

    def begin(self, device: torch.device) -> None:  # noqa: B027 (most learn nothing)
        """Learn on this device, where the episodes will be; called once, before all else."""

    def learn(self, episodes: WholeEpisodes, to_go: Tensor) -> Mapping[str, float]:
        """Learn from a batch after it was used; most learn nothing. Gives figures to be recorded, by name.

        Args:
            episodes: shape (…, t).
            to_go: their returns-to-go, shape (…, t).
        """
        del episodes, to_go
        return {}

    def explore_anew(self, seed: int) -> None:  # noqa: B027 (most draw nothing)
        """Learn by the random numbers of this seed from here on."""

    def state_dict(self) -> dict[str, Any]:
        """What was learnt."""
        return {}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:  # noqa: B027 (few learn)
        """Continue from what `state_dict` gave."""
