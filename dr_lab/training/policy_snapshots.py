"""The policies that a run had at its last checkpoints, and which of them is deployed."""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from torch import Tensor, nn

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.bounds import Count, require_bounds
from dr_lab.collectors.boundary import on_cpu
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.play import outcomes, play
from dr_lab.envs.environment import Environment
from dr_lab.envs.slots import Flags
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.seeding import derived_seed, stream
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class PolicySnapshot:
    """A policy as it was.

    Attributes:
        frames: control steps that it was trained for.
        exploring: as it collected experience.
        deployed: without exploration.
    """

    frames: int
    exploring: Policy
    deployed: Policy


class PolicySnapshots:
    """Keeps what an algorithm's policies were at the last few checkpoints.

    Args:
        algorithm: whose policies are torch modules.
        count: snapshots that are kept, the last ones.
    """

    def __init__(self, algorithm: Algorithm, count: int) -> None:
        self._algorithm, self._count = algorithm, count
        self.taken: list[dict[str, Any]] = []

    def take(self, frames: int) -> None:
        """Keep the policies as they are now, after so many control steps."""
        self.taken = [*self.taken, {"frames": frames, "policies": states(self._algorithm)}][-self._count :]

    def restored(self) -> list[PolicySnapshot]:
        """The policies that are kept, oldest first, each a copy of its own on the CPU; the algorithm's stay."""
        present, found = states(self._algorithm), list[PolicySnapshot]()
        for each in self.taken:
            load_states(self._algorithm, each["policies"])
            pair = (self._algorithm.policies["policy"], self._algorithm.deployed)
            found.append(PolicySnapshot(each["frames"], *on_cpu(pair)))
        load_states(self._algorithm, present)
        return found

    def state_dict(self) -> dict[str, Any]:
        """All that is kept."""
        return {"taken": list(self.taken)}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.taken = list(state["taken"])


def states(algorithm: Algorithm) -> dict[str, Any]:
    """State of each policy by its name, a copy on the CPU."""
    found = {name: copy.deepcopy(_module(policy).state_dict()) for name, policy in algorithm.policies.items()}
    for state in found.values():
        state.update({key: value.cpu() for key, value in state.items()})
    return found


def load_states(algorithm: Algorithm, found: Mapping[str, Any]) -> None:
    """Put policies into the state that `states` gave; those that it lacks, being of an earlier version, stay."""
    for name, state in found.items():
        _module(algorithm.policies[name]).load_state_dict(state)


def _module(policy: Policy) -> nn.Module:
    assert isinstance(policy, nn.Module)
    return policy


@dataclass(frozen=True)
class Chosen:
    """Which snapshot is deployed.

    Attributes:
        index: of it, among those that there are.
        returns: mean return of each snapshot; NaN where no context is feasible.
        frames: control steps that were played to find out.
    """

    index: int
    returns: Sequence[float]
    frames: int


@dataclass(frozen=True)
class Choice:
    """Chooses by the mean return of deterministic episodes in contexts of p(z), the same ones for all snapshots.

    Returns of single snapshots scatter by more than they differ from one to the next, so that the last one is a matter
    of luck. The return by which one was chosen is too high, by the same luck: `dr-lab evaluate` plays other episodes.

    A context that is infeasible with all snapshots, as where it does not compile, is left out. In the others an episode
    that diverges counts with the return that the environment declares.

    Attributes:
        snapshots: how many a run keeps, the last ones; one where no return judges, see `Algorithm.judged_by_return`.
        episodes: that each snapshot plays.

    Raises:
        ConfigError: a number is too small.
    """

    snapshots: Count
    episodes: Count

    def __post_init__(self) -> None:
        require_bounds(self, "choice")

    def choose(
        self,
        snapshots: Sequence[PolicySnapshot],
        environment: Environment,
        source: ContextSource,
        seed: int,
        threads: int | None,
    ) -> Chosen:
        """Play all of them; the newest of the best is chosen.

        Args:
            snapshots: one at least.
            environment: what is played.
            source: p(z).
            seed: of contexts and starts, which no training or evaluation of the same seed draws.
            threads: C threads of the physics; None takes every core.
        """
        z = source.propose([stream(seed, "choice")] * self.episodes, np.arange(self.episodes)).z
        found, frames = list[tuple[Array, Flags]](), 0
        for snapshot in snapshots:
            slots = environment.make(None, self.episodes, derived_seed(seed, "choice"), threads).episodes
            played = play(slots, snapshot.deployed, z)
            found.append(outcomes(played))
            frames += int(cast(Tensor, played["mask"]).sum())
        returns, infeasible = (np.stack(each) for each in zip(*found, strict=True))
        known = ~infeasible.all(axis=0)
        means = returns[:, known].mean(axis=1) if known.any() else np.full(len(returns), np.nan)
        return Chosen(len(means) - 1 - int(np.argmax(means[::-1])), means.tolist(), frames)
