"""The contract of a baseline: what an episode returns on average, whatever action is taken."""

from abc import ABC, abstractmethod

from torch import Tensor

from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes


class Baseline(ABC):
    """b(o_t, t), which is taken off the returns-to-go so that the gradient scatters less.

    That of an episode comes from other episodes alone, so that it depends on none of the episode's actions and leaves
    the gradient's expectation as it is. It comes from the same batch, so that nothing of it is kept between batches.
    """

    @abstractmethod
    def __call__(self, episodes: WholeEpisodes, to_go: Tensor) -> Tensor:
        """Baseline of every step, shape (k, t); what it is beyond an episode's end has no meaning.

        Args:
            episodes: k, independent of one another.
            to_go: their returns-to-go, shape (k, t).
        """
