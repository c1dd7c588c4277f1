"""What algorithms and distribution learners may do with the environment."""

from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.boundary import Boundary
from dr_lab.collectors.collector import Collector, Drive, Policy
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.collectors.play import play
from dr_lab.envs.slots import EpisodeSlots, Starts
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import UNKEYED, ContextSource, Keys, Proposals
from dr_lab.trajectory import Array


class Experience:
    """Batches of the policy that is trained, and whole episodes of any policy in any context.

    Both have slots of their own: what is played disturbs no episode that is being collected.

    Everything is played on the CPU, and who listens hears of it there. Only what is collected crosses the boundary to
    the device on which policies learn.

    Args:
        collector: collects with `policy`.
        policy: the one that is trained, as it is then, on the CPU.
        episodes: slots of the whole episodes.
        source: p(z), from which a collector's new episodes draw; None for the nominal context.
        deployed: the same policy without exploration; None where it explores nothing.
        boundary: between the CPU and that device; None where it is the CPU.

    Attributes:
        rollout_frames: control steps of the whole episodes that were played so far, beside those that were collected.
    """

    def __init__(
        self,
        collector: Collector,
        policy: Policy,
        episodes: EpisodeSlots,
        source: ContextSource | None = None,
        deployed: Policy | None = None,
        boundary: Boundary | None = None,
    ) -> None:
        self.policy, self.source, self.deployed = policy, source, deployed or policy
        self.rollout_frames = 0
        self._collector, self._episodes = collector, episodes
        self._boundary = boundary or Boundary()
        self._listeners: list[Callable[[TensorDict], None]] = []

    def listen(self, listener: Callable[[TensorDict], None]) -> None:
        """Call the listener with every batch, before who collects it has it."""
        self._listeners.append(listener)

    def collect(self) -> TensorDict:
        """The next batch of the present policy, as `Collector` lays it out."""
        self._boundary.renew()
        return self._told(next(self._collector))

    def collect_whole(self, z: Array, labels: Mapping[str, Keys] | None = None) -> TensorDict:
        """Begin new episodes and collect until every slot has ended one at least.

        Args:
            z: context of every slot, as `begin` takes it.
            labels: more keys of the batch, one whole number a slot each, so that who listens knows what it is of.

        Returns:
            A batch as `Collector` lays it out, of as many control steps as the longest first episode takes, and what
            else the collector makes at once. What goes on then is cut, and bootstraps, as by a time limit. Its key
            ``first`` (n, steps) says which steps are of each slot's first episode: no others are counted as episodes.
        """
        self._boundary.renew()
        self.begin(z)
        parts, ended = list[TensorDict](), torch.zeros(len(z), dtype=torch.bool)
        while not ended.all():
            parts.append(next(self._collector))
            ended |= cast(Tensor, parts[-1]["next", "done"]).squeeze(-1).any(1)
        batch = cast(TensorDict, torch.cat(cast(list[Tensor], parts), 1))  # torch's signature knows tensors alone
        cut = ~cast(Tensor, batch["next", "done"])[:, -1]
        for flag in ("truncated", "done"):
            batch["next", flag][:, -1] |= cut
        batch["first"] = first_episodes(batch)
        for key, of_slot in (labels or {}).items():
            batch[key] = torch.from_numpy(of_slot)[:, None].expand(batch.shape)
        return self._told(batch)

    def begin(self, z: Array | None) -> None:
        """Begin new episodes, which the next batch holds.

        Args:
            z: context of every slot, which also its further episodes have, shape (slots, n); None draws them again.
        """
        self._collector.begin(z)

    def play(self, drive: Drive, z: Array, starts: Starts | None = None) -> TensorDict:
        """Whole episodes, one in each context; arguments and result as those of `collectors.play.play`, on the CPU."""
        self._boundary.renew()
        played = play(self._episodes, self._boundary.playing(drive), z, starts)
        self.rollout_frames += int(cast(Tensor, played["mask"]).sum())
        return played

    def executed(self, batch: TensorDict) -> TensorDict:
        """A batch, or what was played, with actions as the machine does them: cut off at its bounds."""
        low, high = (torch.from_numpy(bound).float() for bound in (self._episodes.low, self._episodes.high))
        return batch.copy().set("action", cast(Tensor, batch["action"]).clamp(low, high))

    @property
    def space(self) -> ContextSpace:
        """The parameters of a context."""
        return self._episodes.space

    def contexts(self, rng: np.random.Generator, count: int) -> Array:
        """Draws of p(z), shape (count, n)."""
        return self.propose(rng, count).z

    def propose(self, rng: np.random.Generator, count: int) -> Proposals:
        """The same with the keys by which their source knows them."""
        if self.source is None:
            return Proposals(np.tile(self.space.nominal, (count, 1)), np.full(count, UNKEYED, np.int64))
        return self.source.propose([rng] * count, np.arange(count))

    def close(self) -> None:
        """End what the collector keeps running, such as workers on other machines."""
        self._collector.close()

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "collector": self._collector.state_dict(),
            "episodes": self._episodes.state_dict(),
            "rollout_frames": self.rollout_frames,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._collector.load_state_dict(state["collector"])
        self._episodes.load_state_dict(state["episodes"])
        self.rollout_frames = state["rollout_frames"]

    def _told(self, batch: TensorDict) -> TensorDict:
        with torch.enable_grad():  # who collects may want no gradients, who listens may learn by them
            for listener in self._listeners:
                listener(batch)
        return self._boundary.across(batch)
