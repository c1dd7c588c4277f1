"""What algorithms and distribution learners may do with the environment."""

from collections.abc import Callable, Mapping
from typing import Any

from tensordict import TensorDict

from dr_lab.collectors.collector import Collector, Policy
from dr_lab.collectors.play import play
from dr_lab.envs.slots import EpisodeSlots, Starts
from dr_lab.trajectory import Array


class Experience:
    """Batches of the policy that is trained, and whole episodes of any policy in any context.

    Both have slots of their own: what is played disturbs no episode that is being collected.

    Args:
        collector: collects with `policy`.
        policy: the one that is trained, as it is then.
        episodes: slots of the whole episodes.
    """

    def __init__(self, collector: Collector, policy: Policy, episodes: EpisodeSlots) -> None:
        self.policy = policy
        self._collector, self._episodes = collector, episodes
        self._listeners: list[Callable[[TensorDict], None]] = []

    def listen(self, listener: Callable[[TensorDict], None]) -> None:
        """Call the listener with every batch, before who collects it has it."""
        self._listeners.append(listener)

    def collect(self) -> TensorDict:
        """The next batch of the present policy, as `Collector` lays it out."""
        batch = next(self._collector)
        for listener in self._listeners:
            listener(batch)
        return batch

    def begin(self, z: Array | None) -> None:
        """Begin new episodes, which the next batch holds.

        Args:
            z: context of every slot, which also its further episodes have, shape (slots, n); None draws them again.
        """
        self._collector.begin(z)

    def play(self, policy: Policy, z: Array, starts: Starts | None = None) -> TensorDict:
        """Whole episodes of a policy, one in each context; arguments and result as those of `collectors.play.play`."""
        return play(self._episodes, policy, z, starts)

    def close(self) -> None:
        """End what the collector keeps running, such as workers on other machines."""
        self._collector.close()

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"collector": self._collector.state_dict(), "episodes": self._episodes.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._collector.load_state_dict(state["collector"])
        self._episodes.load_state_dict(state["episodes"])
