"""What slots have in common, whatever moves their machines: random streams, contexts, and ages."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dr_lab.envs.slots import Rows
from dr_lab.errors import ModelError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import UNKEYED, ContextSource, Proposals
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


class ContextSlots:
    """n slots that draw their contexts from random streams of their own; the base of what fulfils `EpisodeSlots`.

    Args:
        space: the context z.
        source: where contexts are drawn from; None keeps every episode at the nominal context.
        nsim: n.
        seed: of all random draws.
        show_context: whether the policy sees z behind the task's observation, as (z − low) / (high − low).

    Attributes:
        space: the context.
        source: where contexts are drawn from.
        contexts: z of the running episodes, shape (n, parameters).
        proposals: which proposal of the source each of these is, shape (n,).
    """

    def __init__(
        self, space: ContextSpace, source: ContextSource | None, nsim: int, seed: int, *, show_context: bool
    ) -> None:
        self.space, self.source = space, source
        self.contexts = np.tile(space.nominal, (nsim, 1))
        self.proposals = np.full(nsim, UNKEYED, np.int64)
        self._show_context = show_context
        self._streams = [stream(seed, "episode", slot) for slot in range(nsim)]
        self._slots = np.arange(nsim)  # among all that train, some of which others may play
        self._given: Array | None = None

    @property
    def nsim(self) -> int:
        """Number of episodes that run side by side."""
        return len(self.contexts)

    def give_contexts(self, z: Array | None) -> None:
        """Let slot i begin every further episode with context z[i], shape (n, parameters); None draws again."""
        if z is not None and z.shape != self.contexts.shape:
            raise ModelError(f"Contexts have shape {z.shape}; expected one for each episode, {self.contexts.shape}.")
        self._given = None if z is None else np.array(z, dtype=float)

    def _renew(self, rows: Rows) -> list[np.random.Generator]:
        """Draw the contexts with which slots begin anew; gives the slots' streams."""
        streams = [self._streams[row] for row in rows]
        drawn = self._draw(streams, rows)
        self.contexts, self.proposals = self.contexts.copy(), self.proposals.copy()  # what was handed out stays
        self.contexts[rows], self.proposals[rows] = drawn.z, drawn.keys
        return streams

    def _with_context(self, observation: Array, contexts: Array) -> Array:
        """What the policy sees: an observation (k, o) and, if it is shown, the context (k, parameters)."""
        if not self._show_context:
            return observation
        return np.concatenate([observation, self.space.to_unit(contexts)], axis=1)

    def _context_state(self) -> dict[str, Any]:
        """All that future contexts depend on, apart from the source."""
        return {
            "contexts": self.contexts,
            "proposals": self.proposals,
            "slots": self._slots,
            "given": self._given,
            "streams": [rng.bit_generator.state for rng in self._streams],
        }

    def _load_context_state(self, state: Mapping[str, Any]) -> None:
        """Go on where `_context_state` was taken."""
        self.contexts, self._given = state["contexts"], state["given"]
        self.proposals, self._slots = state["proposals"], state["slots"]
        for rng, remembered in zip(self._streams, state["streams"], strict=True):
            rng.bit_generator.state = remembered

    def _draw(self, streams: Sequence[np.random.Generator], rows: Rows) -> Proposals:
        if self._given is None and self.source is not None:
            return self.source.propose(streams, self._slots[rows])
        z = np.tile(self.space.nominal, (len(rows), 1)) if self._given is None else self._given[rows]
        return Proposals(z, np.full(len(rows), UNKEYED, np.int64))


def first_ages(slots: int, time_limit: int) -> Rows:
    """Control steps that the time limit counts for each slot before its first episode begins, shape (slots,).

    Slots that begin together would stay in step wherever every episode lasts to the time limit: each batch would hold
    one phase of the episode, and all contexts would change at once. Slot i starts at the age ⌊T·frac(i·φ)⌋, T being the
    time limit and φ the golden ratio's fraction 0.618, so that ages are even over any neighbouring slots.
    """
    return (time_limit * ((np.arange(slots) * _GOLDEN) % 1.0)).astype(np.intp)
