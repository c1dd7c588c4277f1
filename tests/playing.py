"""Environments played with random actions and contexts."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dr_lab.envs.episodes import Episodes
from dr_lab.envs.setting import Setting
from dr_lab.randomizers.context_source import UNKEYED, Proposals
from dr_lab.trajectory import Array


class Uniform:
    """A randomizer, made as simple as it can be: uniform over the inner part of the bounds."""

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high = low, high

    def propose(self, rngs: Sequence[np.random.Generator], slots: NDArray[np.intp]) -> Proposals:
        z = np.array([rng.uniform(self.low, self.high) for rng in rngs])
        return Proposals(z, np.full(len(slots), UNKEYED, np.int64))


def begun(of: Setting, slots: int = 3, seed: int = 0, *, random: bool = False) -> Episodes:
    space = of.space
    source = Uniform(0.8 * space.nominal + 0.2 * space.low, 0.8 * space.nominal + 0.2 * space.high)
    return of.make(source if random else None, slots, seed, threads=1).episodes


def actions(episodes: Episodes, seed: int = 0) -> Array:
    rng = np.random.default_rng(seed)
    return rng.uniform(episodes.low, episodes.high, (episodes.nsim, len(episodes.low)))


def played(episodes: Episodes, steps: int, seed: int = 0) -> Array:
    """Rewards and observations of so many steps, with new episodes where one ended; shape (steps, n, 1 + o)."""
    kept = []
    for k in range(steps):
        outcome = episodes.step(actions(episodes, seed + k))
        kept.append(np.concatenate([outcome.reward[:, None], outcome.observation], axis=1))
        if outcome.done.any():
            episodes.begin(np.flatnonzero(outcome.done))
    return np.array(kept)
