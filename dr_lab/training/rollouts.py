"""Returns of a policy in contexts of one's choice."""

from dr_lab.collectors.collector import Policy
from dr_lab.collectors.play import play, undiscounted
from dr_lab.envs.slots import EpisodeSlots
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
        return undiscounted(play(self._episodes, self._policy, z))
