"""The contract of episodes that run side by side, whatever moves their machines."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import ContextSource, Keys
from dr_lab.trajectory import Array

Flags = NDArray[np.bool_]
Rows = NDArray[np.intp]

Starts = tuple[Array, Array]
"""Positions (k, nq) and velocities (k, nv) with which episodes begin."""


@dataclass(frozen=True)
class StepOutcome:
    """What one control step of n episodes led to.

    Attributes:
        observation: what the policy sees now, shape (n, o); of an episode that ended, the last it saw.
        reward: shape (n,).
        terminated: the episode came to its end, shape (n,).
        truncated: it was cut by the time limit, shape (n,).
        infeasible: it came to its end because its context is infeasible, shape (n,).
    """

    observation: Array
    reward: Array
    terminated: Flags
    truncated: Flags
    infeasible: Flags

    @property
    def done(self) -> Flags:
        """Where the next step needs a new episode, shape (n,)."""
        return self.terminated | self.truncated


class EpisodeSlots(Protocol):
    """n episodes of one task, each with its own context, as training plays them.

    Each slot draws contexts and starts from a random stream of its own. What was handed out is never written to again.
    """

    source: ContextSource | None
    """Where contexts are drawn from; None keeps every episode at the nominal context."""

    @property
    def nsim(self) -> int:
        """Number of episodes that run side by side."""
        ...

    @property
    def space(self) -> ContextSpace:
        """The context: parameters of the machine, then of the task."""
        ...

    @property
    def low(self) -> Array:
        """Lowest action, shape (nu,)."""
        ...

    @property
    def high(self) -> Array:
        """Highest action, shape (nu,)."""
        ...

    @property
    def observation(self) -> Array:
        """What the policy sees now, shape (n, o)."""
        ...

    @property
    def contexts(self) -> Array:
        """Contexts z of the running episodes, shape (n, parameters)."""
        ...

    @property
    def proposals(self) -> Keys:
        """Which proposal of the source each of these is, shape (n,)."""
        ...

    @property
    def state(self) -> tuple[Array, Array]:
        """Copies of the positions (n, nq) and velocities (n, nv)."""
        ...

    def give_contexts(self, z: Array | None) -> None:
        """Let slot i begin every further episode with context z[i], shape (n, parameters); None draws again."""
        ...

    def begin(self, rows: Rows, starts: Starts | None = None) -> None:
        """Begin new episodes in these slots; the others are not touched.

        Args:
            rows: the slots.
            starts: what they begin with, row by row; None draws it from each slot's stream.
        """
        ...

    def step(self, action: Array) -> StepOutcome:
        """One control step of all episodes, whose actions (n, nu) are cut off at their bounds."""
        ...

    def state_dict(self) -> dict[str, Any]:
        """All that the episodes' future depends on; what has one row a slot is an array or a list of length n."""
        ...

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where the `state_dict` of like episodes was taken."""
        ...
