"""Which episodes ended within a batch, in which context, and what they returned."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from tensordict import TensorDict
from torch import Tensor

from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Finished:
    """Episodes that ended, k of them.

    Attributes:
        context: z, shape (k, n).
        returns: undiscounted, shape (k,).
        lengths: control steps, shape (k,).
        infeasible: whether an infeasible context ended the episode, shape (k,).
    """

    context: Array
    returns: Array
    lengths: NDArray[np.int64]
    infeasible: NDArray[np.bool_]

    def figures(self) -> dict[str, float]:
        """How many there are, and the mean return and length of the feasible ones; NaN where none is."""
        feasible = ~self.infeasible
        known = feasible.any()
        return {
            "episodes": float(len(feasible)),
            "episode_return": float(self.returns[feasible].mean()) if known else np.nan,
            "episode_length": float(self.lengths[feasible].mean()) if known else np.nan,
            "infeasible_episodes": float(self.infeasible.sum()),
        }


def joined(parts: Sequence[Finished]) -> Finished:
    """The episodes of several batches, one at least, in their order."""
    return Finished(
        np.concatenate([part.context for part in parts]),
        np.concatenate([part.returns for part in parts]),
        np.concatenate([part.lengths for part in parts]),
        np.concatenate([part.infeasible for part in parts]),
    )


class EpisodeLog:
    """Follows the episodes of n slots from batch to batch.

    Args:
        time_limit: control steps of a whole episode. What was cut before, as first episodes are where slots are
            staggered, is no episode whose return is known, and is left out.
    """

    def __init__(self, time_limit: int = 0) -> None:
        self._time_limit = time_limit
        self._returns: Array = np.zeros(0)
        self._lengths: NDArray[np.int64] = np.zeros(0, np.int64)

    def take(self, batch: TensorDict) -> Finished:
        """Follow one more batch.

        Args:
            batch: size [n, steps], as a collector gives it. Where it has the key ``first``, no other episodes are
                counted: of those that follow only the short ones end before the batch does.

        Returns:
            What ended within it as a whole, in the order of time.
        """
        reward = cast(Tensor, batch["next", "reward"]).squeeze(-1).double().numpy()
        done = cast(Tensor, batch["next", "done"]).squeeze(-1).numpy()
        terminated = cast(Tensor, batch["next", "terminated"]).squeeze(-1).numpy()
        infeasible = cast(Tensor, batch["next", "infeasible"]).squeeze(-1).numpy()
        context = cast(Tensor, batch["context"]).double().numpy()
        counted = cast(Tensor, batch["first"]).numpy() if "first" in batch else np.ones_like(done)
        if len(self._returns) == 0:
            self._returns, self._lengths = np.zeros(len(reward)), np.zeros(len(reward), np.int64)
        found = [Finished(context[:0, 0], np.zeros(0), np.zeros(0, np.int64), np.zeros(0, bool))]
        for t in range(reward.shape[1]):
            self._returns += reward[:, t]
            self._lengths += 1
            ended = done[:, t]
            whole = ended & counted[:, t] & (terminated[:, t] | (self._lengths >= self._time_limit))
            found.append(Finished(context[whole, t], self._returns[whole], self._lengths[whole], infeasible[whole, t]))
            self._returns[ended], self._lengths[ended] = 0.0, 0
        return joined(found)

    def state_dict(self) -> dict[str, Any]:
        """What is known of the episodes that go on."""
        return {"returns": self._returns.copy(), "lengths": self._lengths.copy()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._returns, self._lengths = state["returns"].copy(), state["lengths"].copy()
