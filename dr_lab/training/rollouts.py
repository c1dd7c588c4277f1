"""Returns of a policy in contexts of one's choice."""

import numpy as np

from dr_lab.collectors.collector import Policy
from dr_lab.collectors.play import outcomes, play
from dr_lab.envs.slots import EpisodeSlots, Flags
from dr_lab.trajectory import Array


class PolicyRollouts:
    """Plays a policy, as it is then, on episodes that are kept for this purpose.

    Args:
        episodes: slots that run side by side; more contexts than slots are played one load after the other.
        policy: what acts.
    """

    def __init__(self, episodes: EpisodeSlots, policy: Policy) -> None:
        self._episodes = episodes
        self._policy = policy

    def returns(self, z: Array) -> Array:
        """Undiscounted return of an episode in each context (k, n), shape (k,); NaN where the context is infeasible."""
        returns, infeasible = self.outcomes(z)
        return np.where(infeasible, np.nan, returns)

    def outcomes(self, z: Array) -> tuple[Array, Flags]:
        """Undiscounted return of an episode in each context (k, n), and whether it is infeasible, shape (k,) each.

        The return of an infeasible one is what the environment declares. Of a load no more is kept than that: the
        courses of thousands of episodes would fill the memory.
        """
        width = self._episodes.nsim
        loads = (z[first : first + width] for first in range(0, len(z), width))
        returns, infeasible = zip(*(outcomes(play(self._episodes, self._policy, load)) for load in loads), strict=True)
        return np.concatenate(returns), np.concatenate(infeasible)
