"""Which contexts were drawn for training, and when."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from tensordict import TensorDict
from torch import Tensor

from dr_lab.randomizers.context_source import UNKEYED, Keys
from dr_lab.trajectory import Array

FILE = "contexts.csv"


class DrawnContexts:
    """Follows the contexts of n slots from batch to batch and keeps each that is drawn.

    A context is drawn where a slot plays another one than before. A proposal that has a key counts once, however many
    slots take it up; others that several slots begin with at once, as those of one task do, count once, too. They are
    noted when episodes begin, not when they end, which would favour contexts with short episodes.
    """

    def __init__(self) -> None:
        self._slots: Array = np.zeros((0, 0))  # context of each, shape (n, k)
        self._seen = 0  # control steps
        self._frames: NDArray[np.int64] = np.zeros(0, np.int64)  # seen before each drawn context, shape (m,)
        self._keys: Keys = np.zeros(0, np.int64)
        self._drawn: Array = np.zeros((0, 0))  # shape (m, k)

    def take(self, batch: TensorDict) -> None:
        """Follow one more batch, of size [n, steps], as a collector gives it."""
        context = cast(Tensor, batch["context"]).double().numpy()
        slots, steps, size = context.shape
        if self._slots.shape != (slots, size):
            self._slots = np.full((slots, size), np.nan)
        before = np.concatenate([self._slots[:, None], context[:, :-1]], axis=1)
        at, slot = np.nonzero((context != before).any(axis=2).T)  # in the order of time
        if len(at):
            keys = cast(Tensor, batch["proposal"]).numpy()[slot, at]
            self._note(self._seen + at * slots, keys, context[slot, at])
        self._slots, self._seen = context[:, -1].copy(), self._seen + slots * steps

    def csv(self, names: Sequence[str]) -> str:
        """A row a context in the order of time: control steps of training before it, ``frames``, and its values.

        Args:
            names: of the parameters, whose SI units the values have.
        """
        rows = zip(self._frames.tolist(), self._drawn.tolist(), strict=True)
        lines = [",".join([str(frames), *(repr(value) for value in z)]) for frames, z in rows]
        return "\n".join([",".join(["frames", *names]), *lines, ""])

    def state_dict(self) -> dict[str, Any]:
        """All that was kept."""
        parts = {"slots": self._slots, "frames": self._frames, "keys": self._keys, "drawn": self._drawn}
        return {"seen": self._seen, **{name: part.copy() for name, part in parts.items()}}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._seen, self._slots = state["seen"], state["slots"].copy()
        self._frames, self._keys, self._drawn = (state[name].copy() for name in ("frames", "keys", "drawn"))

    def _note(self, frames: NDArray[np.int64], keys: Keys, z: Array) -> None:
        """Keep what is new of the contexts (m, k) that slots begin with."""
        alone = _first(np.column_stack([frames, z]))
        once = _first(keys[:, None]) & ~np.isin(keys, self._keys)
        new = np.where(keys == UNKEYED, alone, once)
        self._frames, self._keys = (
            np.concatenate(pair) for pair in ((self._frames, frames[new]), (self._keys, keys[new]))
        )
        self._drawn = np.concatenate([self._drawn.reshape(-1, z.shape[1]), z[new]])


def _first(rows: NDArray[Any]) -> NDArray[np.bool_]:
    """Whether no row above is like it, shape (m,), of rows (m, k)."""
    found = np.zeros(len(rows), bool)
    found[np.unique(rows, axis=0, return_index=True)[1]] = True
    return found
