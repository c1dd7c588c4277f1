"""The contexts that particles propose, and which of them a finished episode has answered."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dr_lab.randomizers.context_source import Keys, Proposals
from dr_lab.trajectory import Array


class OpenProposals:
    """The proposals of one round, with running keys; a `ContextSource`.

    A slot that begins an episode draws among the proposals that wait: no episode has answered them, and none was under
    way with them when the last batch ended. Where none waits it draws among all of the round: if it took up what is
    still under way, contexts with long episodes would be trained on more than others.

    Attributes:
        z: contexts of the round, shape (k, n).
        first: key of the first; that of the others follow it.
    """

    def __init__(self, z: Array) -> None:
        self.z, self.first = z, 0
        self._answered, self._running = np.zeros(len(z), bool), np.zeros(len(z), bool)

    def renew(self, z: Array) -> None:
        """Begin another round, with keys that go on."""
        self.first += len(self.z)
        self.z = z
        self._answered, self._running = np.zeros(len(z), bool), np.zeros(len(z), bool)

    @property
    def answered(self) -> bool:
        """Whether all are."""
        return bool(self._answered.all())

    def answer(self, key: int) -> int | None:
        """Place in the round of a proposal that an episode has answered; None of another round or answered before."""
        place = key - self.first
        if not 0 <= place < len(self.z) or self._answered[place]:
            return None
        self._answered[place] = True
        return place

    def run(self, keys: Keys) -> None:
        """Note the keys of the episodes that are under way."""
        places = keys - self.first
        self._running[:] = False
        self._running[places[(places >= 0) & (places < len(self.z))]] = True

    def propose(self, rngs: Sequence[np.random.Generator], slots: NDArray[np.intp]) -> Proposals:
        """One of the proposals a stream, alike in every slot."""
        del slots
        waiting = np.flatnonzero(~self._answered & ~self._running)
        choice = waiting if len(waiting) else np.arange(len(self.z))
        picked = np.array([choice[rng.integers(len(choice))] for rng in rngs], np.int64)
        return Proposals(self.z[picked], self.first + picked)

    def state_dict(self) -> dict[str, Any]:
        """The round."""
        parts = {"z": self.z, "answered": self._answered, "running": self._running}
        return {"first": self.first, **{name: part.copy() for name, part in parts.items()}}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.z, self.first = state["z"].copy(), state["first"]
        self._answered, self._running = state["answered"].copy(), state["running"].copy()
