"""Returns of kept policies, and what of them counts where contexts are infeasible."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blocks_with_goals import subject
from numpy.typing import NDArray
from torch import Tensor

from dr_lab.collectors.collector import Policy
from dr_lab.evaluators.evaluator import Evaluation, Subject
from dr_lab.evaluators.snapshots import SnapshotsEvaluator
from dr_lab.training.policy_snapshots import PolicySnapshot
from dr_lab.trajectory import Array

DECLARED = -1000.0  # return of an infeasible episode


@dataclass(frozen=True)
class Told:
    """A policy that returns its worth in every context, and diverges in some."""

    worth: float
    diverges: tuple[int, ...] = ()

    def __call__(self, observation: Tensor) -> Tensor:
        raise AssertionError


@dataclass(frozen=True)
class Scripted(Subject):
    """Contexts by number, of which some compile for no policy."""

    broken: tuple[int, ...] = ()

    def rollouts(self, episodes: int, seed: int, policy: Policy | None = None) -> Any:  # noqa: ANN401
        del seed
        assert isinstance(policy, Told)
        return Outcomes(policy.worth, np.isin(np.arange(episodes), [*self.broken, *policy.diverges]))


@dataclass(frozen=True)
class Outcomes:
    worth: float
    infeasible: NDArray[np.bool_]

    def outcomes(self, z: Array) -> tuple[Array, NDArray[np.bool_]]:
        assert len(z) == len(self.infeasible)
        return np.where(self.infeasible, DECLARED, self.worth), self.infeasible


def evaluated(*snapshots: tuple[Told, Told], broken: tuple[int, ...]) -> Evaluation:
    run = subject()
    kept = [PolicySnapshot(100 * k, exploring, deployed) for k, (deployed, exploring) in enumerate(snapshots, start=1)]
    scripted = Scripted(run.name, run.setting, run.policy, run.again, snapshots=kept, broken=broken)
    evaluator = SnapshotsEvaluator(episodes=4, confidence=0.95, resamples=50, seed=0)
    return evaluator.evaluate(scripted, Path(), lambda _: None)


def test_a_context_that_compiles_for_nobody_counts_for_nothing() -> None:
    found = evaluated((Told(1.0), Told(2.0)), (Told(3.0), Told(4.0)), broken=(0, 2))
    assert [(row["frames"], row["deterministic"], row["stochastic"]) for row in found.rows] == [
        (100, 1, 2),
        (200, 3, 4),
    ]
    assert (found.figures["infeasible"], found.figures["diverged"]) == (0.5, 0.0)
    assert (found.figures["deterministic.iqm"], found.figures["stochastic.last"]) == (2.0, 4.0)


def test_where_one_policy_diverges_and_another_does_not_the_declared_return_counts() -> None:
    found = evaluated((Told(1.0), Told(2.0, diverges=(3,))), (Told(3.0), Told(4.0)), broken=(0, 2))
    assert [row["stochastic"] for row in found.rows] == [(2.0 + DECLARED) / 2, 4.0]
    assert [row["diverged"] for row in found.rows] == [0.25, 0.0]
    assert (found.figures["infeasible"], found.figures["diverged"]) == (0.5, 0.125)


def test_where_nothing_is_feasible_no_return_is_told() -> None:
    found = evaluated((Told(1.0), Told(2.0)), broken=(0, 1, 2, 3))
    assert found.figures["infeasible"] == 1.0
    assert all(np.isnan(value) for name, value in found.figures.items() if name != "infeasible")


def test_real_episodes_are_played_in_their_own_slots() -> None:
    """The scripted outcomes above have the form of those of a run."""
    run = subject()
    kept = [PolicySnapshot(100, run.policy, run.policy)]
    evaluator = SnapshotsEvaluator(episodes=2, confidence=0.95, resamples=50, seed=0)
    found = evaluator.evaluate(replace(run, snapshots=kept), Path(), lambda _: None)
    assert found.rows == [
        {"frames": 100.0, "deterministic": pytest.approx(0.0), "stochastic": pytest.approx(0.0), "diverged": 0.0}
    ]
