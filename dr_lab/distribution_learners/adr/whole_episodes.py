"""Whole episodes, pieced together from batches that hold parts of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import torch
from tensordict import TensorDict
from torch import Tensor


@dataclass(frozen=True)
class WholeEpisode:
    """An episode from its start to its end.

    Attributes:
        key: which proposal of the source its context is.
        transitions: (s, a, s′) side by side, shape (t, 2o + nu).
        infeasible: whether an infeasible context ended it.
    """

    key: int
    transitions: Tensor
    infeasible: bool


def transitions(batch: TensorDict, hidden: int) -> Tensor:
    """(s, a, s′) of every row, side by side, shape (…, 2(o − h) + nu).

    Args:
        batch: as a collector or `play` lays it out.
        hidden: h, how many of the observations, the last ones, are left out.
    """
    now, action, then = (cast(Tensor, batch[key]) for key in ("observation", "action", ("next", "observation")))
    shown = now.shape[-1] - hidden
    return torch.cat([now[..., :shown], action, then[..., :shown]], -1)


class EpisodeAssembler:
    """Follows the episodes of n slots from batch to batch.

    The first episode of a slot is left out where it was truncated: slots are staggered, so that it may have been cut
    early.

    Args:
        hidden: how many of the observations, the last ones, are left out.
    """

    def __init__(self, hidden: int) -> None:
        self._hidden = hidden
        self._parts: list[Tensor] = []  # of each batch that holds some of what goes on, (n, steps, f)
        self._kept = 0  # control steps of them
        self._ages: list[int] = []  # of the episodes that go on, in control steps, one a slot
        self._first: list[bool] = []  # whether a slot has ended none yet

    def take(self, batch: TensorDict) -> list[WholeEpisode]:
        """Follow one more batch, size [n, steps]; gives what ended in it, slot by slot."""
        slots, steps = batch.shape
        if not self._ages:
            self._ages, self._first = [0] * slots, [True] * slots
        self._parts.append(transitions(batch, self._hidden))
        self._kept += steps
        flags = {key: cast(Tensor, batch["next", key])[..., 0] for key in ("done", "terminated", "infeasible")}
        begun, found = [-age for age in self._ages], list[WholeEpisode]()
        for slot, t in cast(list[list[int]], flags["done"].nonzero().tolist()):
            if flags["terminated"][slot, t] or not self._first[slot]:
                rows = self._rows(slot, begun[slot] - steps, t + 1 - steps)
                found.append(WholeEpisode(int(batch["proposal"][slot, t]), rows, bool(flags["infeasible"][slot, t])))
            begun[slot], self._first[slot] = t + 1, False
        self._ages = [steps - start for start in begun]
        self._forget()
        return found

    def state_dict(self) -> dict[str, Any]:
        """What is known of the episodes that go on."""
        return {"parts": list(self._parts), "ages": list(self._ages), "first": list(self._first)}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._parts, self._ages, self._first = list(state["parts"]), list(state["ages"]), list(state["first"])
        self._kept = sum(part.shape[1] for part in self._parts)

    def _rows(self, slot: int, start: int, end: int) -> Tensor:
        """Transitions of a slot between two control steps, counted from the end of the newest batch (≤ 0)."""
        found, at = list[Tensor](), 0
        for part in reversed(self._parts):
            low, high = max(start - at, -part.shape[1]), min(end - at, 0)
            if low < high:
                found.append(part[slot, part.shape[1] + low : part.shape[1] + high])
            at -= part.shape[1]
            if at <= start:
                break
        return torch.cat(found[::-1])

    def _forget(self) -> None:
        oldest = max(self._ages)
        while self._parts and self._kept - self._parts[0].shape[1] >= oldest:
            self._kept -= self._parts.pop(0).shape[1]
