"""The whole episodes in a batch of `Experience.collect_whole`."""

from typing import cast

from tensordict import TensorDict
from torch import Tensor


def first_episodes(batch: TensorDict) -> Tensor:
    """Which steps are of each slot's first episode, its last step included, shape (n, steps).

    A slot whose episode ends early plays on. To count what follows, too, would count short episodes more often.

    Args:
        batch: size [n, steps], of which every slot begins an episode at the first step and ends it.
    """
    done = cast(Tensor, batch["next", "done"]).squeeze(-1).long()
    return done.cumsum(1) - done == 0
