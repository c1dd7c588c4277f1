"""Lunar landers as episodes that run side by side."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from dr_lab.envs.context_slots import ContextSlots, first_ages
from dr_lab.envs.lunar_lander.lander import Landers
from dr_lab.envs.lunar_lander.worker import LanderWorker
from dr_lab.envs.slots import Rows, Starts, StepOutcome
from dr_lab.errors import ConfigError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.simulator import thread_count
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array

_LEAST = 32  # landers of a process: asking one takes 0.1 ms and a wait for it on a busy machine, 32 steps take 1 ms


class LanderEpisodes(ContextSlots):
    """n landers, whose steps are shared by this process and workers; fulfils `EpisodeSlots`.

    Each episode draws a seed from its slot's stream and follows from it, so that no result depends on the number of
    processes. A state holds seeds and actions instead of Box2D's worlds, and to go on from it replays them.
    No context is infeasible.

    Args:
        space: the context.
        powers: those of main and side engines (k, 2) for contexts (k, parameters).
        time_limit: control steps after which an episode is cut.
        source: where contexts are drawn from; None keeps every episode at the nominal context.
        nsim: n.
        seed: of all random draws.
        show_context: whether the policy sees the context.
        threads: processes that step, this one included; None takes one for every core this process may use.
        staggered: whether first episodes are cut at different ages, see `first_ages`; for training alone.

    Attributes:
        low: lowest action: main engine, side engines; shape (2,).
        high: highest action.
        observation: what the policy sees now, shape (n, o).
        infeasible: 0.
    """

    def __init__(
        self,
        space: ContextSpace,
        powers: Callable[[Array], Array],
        time_limit: int,
        source: ContextSource | None,
        nsim: int,
        seed: int,
        *,
        show_context: bool,
        threads: int | None,
        staggered: bool,
    ) -> None:
        super().__init__(space, source, nsim, seed, show_context=show_context)
        self.low, self.high, self.infeasible = -np.ones(2), np.ones(2), 0
        self._powers, self._time_limit = powers, time_limit
        processes = max(1, min(thread_count(threads), nsim // _LEAST))
        self._edges = np.arange(processes + 1) * nsim // processes
        counts = np.diff(self._edges).tolist()
        self._workers = [LanderWorker(count) for count in counts[1:]]
        self._here = Landers(counts[0])
        self._seeds, self._actions = np.zeros(nsim, np.int64), np.zeros((nsim, time_limit, 2))
        self._played, self._ages = np.zeros(nsim, np.intp), np.zeros(nsim, np.intp)
        self._terminated = np.zeros(nsim, bool)
        self._seen = np.zeros((nsim, 8))
        self.begin(np.arange(nsim))
        if staggered:
            self._ages[:] = first_ages(nsim, time_limit)

    @property
    def state(self) -> tuple[Array, Array]:
        """Positions and velocities of the joints of the scene, shape (n, 5) each."""
        position, velocity = zip(*self._ask("state", [()] * len(self._shares)), strict=True)
        return np.concatenate(position), np.concatenate(velocity)

    def begin(self, rows: Rows, starts: Starts | None = None) -> None:
        """Begin new episodes in these slots; the others are not touched.

        Args:
            rows: the slots.
            starts: None; gymnasium draws terrain and first push.

        Raises:
            ConfigError: starts are given.
        """
        if starts is not None:
            raise ConfigError(
                "Landers begin where gymnasium lets them, over ground that it draws; starts cannot be given."
            )
        rows = np.sort(rows)
        self._seeds[rows] = [rng.integers(2**31) for rng in self._renew(rows)]
        self._played[rows], self._ages[rows], self._terminated[rows] = 0, 0, False
        parts = self._dealt(rows, self._seeds[rows].tolist(), self._powers(self.contexts[rows]))
        self._see(rows, np.concatenate(self._ask("begin", parts)))

    def step(self, action: Array) -> StepOutcome:
        """One control step of all episodes that have not ended; the others stay as they are until their `begin`.

        Args:
            action: main engine, side engines; shape (n, 2); what lies outside of ±1 is cut off.
        """
        rows = np.flatnonzero(~self._terminated & ~self._truncated)
        action = np.clip(action, self.low, self.high)[rows]
        self._actions[rows, self._played[rows]] = action
        self._played[rows] += 1
        answers = self._ask("step", self._dealt(rows, action))
        observation, earned, terminated = (np.concatenate(each) for each in zip(*answers, strict=True))
        reward = np.zeros(self.nsim)
        reward[rows] = earned
        self._terminated = self._terminated.copy()
        self._terminated[rows] = terminated
        self._see(rows, observation)
        return StepOutcome(
            self.observation, reward, self._terminated.copy(), self._truncated, np.zeros(self.nsim, bool)
        )

    def state_dict(self) -> dict[str, Any]:
        """All that the episodes' future depends on."""
        return {
            **self._context_state(),
            "seeds": self._seeds.copy(),
            "actions": [course[:steps].copy() for course, steps in zip(self._actions, self._played, strict=True)],
            "ages": self._ages.copy(),
            "terminated": self._terminated.copy(),
            "infeasible": self.infeasible,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Go on where the `state_dict` of like episodes was taken, by playing them again up to there."""
        self._load_context_state(state)
        self._seeds[:], self._ages[:], self._terminated = state["seeds"], state["ages"], state["terminated"].copy()
        for row, course in enumerate(state["actions"]):
            self._actions[row, : len(course)], self._played[row] = course, len(course)
        everything = (self._seeds.tolist(), self._powers(self.contexts), state["actions"])
        parts = [tuple(each[share] for each in everything) for share in self._shares]
        self._see(np.arange(self.nsim), np.concatenate(self._ask("replay", parts)))

    @property
    def _truncated(self) -> np.ndarray:
        return self._ages + self._played >= self._time_limit

    @property
    def _shares(self) -> list[slice]:
        """Slots of this process and of each worker."""
        return [slice(*pair) for pair in itertools.pairwise(self._edges.tolist())]

    def _dealt(self, rows: Rows, *values: Array | list[int]) -> list[tuple[Any, ...]]:
        """Each process' own of these slots, which ascend, by its own count, and of what belongs to each of them."""
        cuts = np.searchsorted(rows, self._edges)
        parts = [slice(*pair) for pair in itertools.pairwise(cuts.tolist())]
        owns = zip(parts, self._edges[:-1], strict=True)
        return [(rows[part] - first, *(each[part] for each in values)) for part, first in owns]

    def _ask(self, method: str, parts: Sequence[tuple[Any, ...]]) -> list[Any]:
        """What a method gives in each process for its own arguments; all work at the same time.

        Raises:
            Exception: the first that a process raises, once all have answered: an answer that is left would be taken
                for that to the next call.
        """
        for worker, arguments in zip(self._workers, parts[1:], strict=True):
            worker.ask(method, *arguments)
        answers, errors = list[Any](), list[Exception]()
        for call in (partial(getattr(self._here, method), *parts[0]), *(worker.answer for worker in self._workers)):
            try:
                answers.append(call())
            except Exception as error:
                errors.append(error)
        if errors:
            raise errors[0]
        return answers

    def _see(self, rows: Rows, observation: Array) -> None:
        """Let the policy see this of these slots (k, 8); what was handed out stays."""
        self._seen = self._seen.copy()
        self._seen[rows] = observation
        self.observation = self._with_context(self._seen, self.contexts)
