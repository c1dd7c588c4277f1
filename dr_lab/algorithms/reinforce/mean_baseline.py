"""The mean of what other episodes return from the same step on."""

from torch import Tensor

from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes


class MeanBaseline(Baseline):
    """b_t = mean of G_t over the other episodes that last beyond t; 0 where none does."""

    def __call__(self, episodes: WholeEpisodes, to_go: Tensor) -> Tensor:
        """The mean without the episode itself."""
        mask = episodes.mask
        others = (mask.sum(0) - mask).clamp(min=1.0)
        return ((to_go * mask).sum(0) - to_go * mask) / others
