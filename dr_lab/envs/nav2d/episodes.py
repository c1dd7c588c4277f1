"""Points that walk in the plane, as episodes that run side by side."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from dr_lab.envs.context_slots import ContextSlots, first_ages
from dr_lab.envs.nav2d.walk import Walk
from dr_lab.envs.slots import Rows, Starts, StepOutcome
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array


class WalkingEpisodes(ContextSlots):
    """n points, which a step moves all at once; fulfils `EpisodeSlots`.

    x' = x + a with every |aᵢ| ≤ stride, r = −‖x' − goal‖; the episode ends where every |x'ᵢ − goalᵢ| < `Walk.reached`.
    No context is infeasible. A velocity is what the last step did, a / seconds, and 0 at the start.

    Args:
        space: the context: the goal's x and y.
        walk: how far a step goes, and when it ends.
        source: where goals are drawn from; None keeps every episode at the nominal one.
        nsim: n.
        seed: of all random draws.
        show_context: whether the policy sees the goal.
        staggered: whether first episodes are cut at different ages, see `first_ages`; for training alone.

    Attributes:
        low: lowest step, m, shape (2,).
        high: highest step.
        observation: what the policy sees now: the place, m, and the goal if it is shown, shape (n, 2 or 4).
        infeasible: 0.
    """

    def __init__(
        self,
        space: ContextSpace,
        walk: Walk,
        source: ContextSource | None,
        nsim: int,
        seed: int,
        *,
        show_context: bool,
        staggered: bool,
    ) -> None:
        super().__init__(space, source, nsim, seed, show_context=show_context)
        self.low, self.high, self.infeasible = np.full(2, -walk.stride), np.full(2, walk.stride), 0
        self._walk = walk
        self._place, self._velocity = np.zeros((nsim, 2)), np.zeros((nsim, 2))
        self._ages = np.zeros(nsim, np.intp)
        self.begin(np.arange(nsim))
        if staggered:
            self._ages[:] = first_ages(nsim, walk.time_limit)

    @property
    def state(self) -> tuple[Array, Array]:
        """Places (n, 2), m, and velocities (n, 2), m/s."""
        return self._place.copy(), self._velocity.copy()

    def begin(self, rows: Rows, starts: Starts | None = None) -> None:
        """Begin new episodes in these slots; the others are not touched.

        Args:
            rows: the slots.
            starts: places and velocities with which they begin, row by row; None begins at the origin, at rest.
        """
        self._renew(rows)
        self._place[rows], self._velocity[rows] = (0.0, 0.0) if starts is None else starts
        self._ages[rows] = 0
        self._see()

    def step(self, action: Array) -> StepOutcome:
        """One control step of all episodes; those that have ended want a `begin` before the next.

        Args:
            action: the step, m, shape (n, 2); what lies outside of ±stride is cut off.
        """
        moved = np.clip(action, self.low, self.high)
        self._place += moved
        self._velocity = moved / self._walk.seconds
        self._ages += 1
        self._see()
        away = self._place - self.contexts
        reward, terminated = -np.hypot(*away.T), np.abs(away).max(axis=1) < self._walk.reached
        never = np.zeros(self.nsim, bool)
        return StepOutcome(self.observation, reward, terminated, self._ages >= self._walk.time_limit, never)

    def state_dict(self) -> dict[str, Any]:
        """All that the episodes' future depends on."""
        place, velocity = self.state
        return {
            **self._context_state(),
            "place": place,
            "velocity": velocity,
            "ages": self._ages.copy(),
            "infeasible": self.infeasible,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where the `state_dict` of like episodes was taken."""
        self._load_context_state(state)
        self._place[:], self._velocity, self._ages[:] = state["place"], state["velocity"].copy(), state["ages"]
        self._see()

    def _see(self) -> None:
        self.observation = self._with_context(self._place.copy(), self.contexts)
