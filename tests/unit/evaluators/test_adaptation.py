"""Adaptation of a block that is pushed along a rail, as in `test_evaluators`: what updates add is known."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
import torch
from scipy import stats
from test_evaluators import Stronger, expected, subject
from torch import Tensor

from dr_lab.collectors.collector import Policy
from dr_lab.errors import ConfigError
from dr_lab.evaluators.adaptation import AdaptationEvaluator
from dr_lab.evaluators.adapted_returns import AdaptedReturns
from dr_lab.evaluators.context_axes import cells, context_axes, in_groups, within
from dr_lab.evaluators.evaluator import MetaLearner, Subject
from dr_lab.evaluators.fine_tune import FineTuneEvaluator
from dr_lab.evaluators.statistics import t_intervals
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.context_source import ContextSource, Proposals
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.recorders.training import ContextAxis
from dr_lab.training.trainer import Trainer
from dr_lab.trajectory import Array

__all__ = ["subject"]  # a fixture
AXIS = {"block.mass": [0.5, 3.5, 4]}


def evaluator(**changes: Any) -> AdaptationEvaluator:  # noqa: ANN401
    few = {"axes": AXIS, "count": 9, "updates": 2, "repeats": 2, "frames": 20, "episodes": 2, "shown": 2}
    return AdaptationEvaluator(**{**few, "confidence": 0.95, "seed": 0, **changes})


class Weaker(Stronger):
    """Pushes with 1 N less for every batch."""

    def run(self, frames: int, watch: Callable[..., None]) -> None:
        super().run(frames, watch)
        self.force = 1.0 - (self.frames - 100) / 10


class Scholar:
    """Stands for a meta-learner of 3 contexts: an update lets the policy of mass m push with m N more."""

    def __init__(self) -> None:
        self.adapted_policies = self
        self.forces, self.heard = np.zeros(3), list[int]()

    def begin_adapting(self) -> None:
        self.forces = np.ones(3)

    def adapt_once(self, experience: "Experiences", tasks: Proposals, done: int) -> None:
        self.heard.append(done)
        experience.collect(60)
        self.forces = self.forces + tasks.z[:, 0]

    def mean(self, observation: Tensor) -> Tensor:
        share = torch.from_numpy(self.forces).float().repeat_interleave(len(observation) // 3)
        return share[:, None]


class Experiences:
    """Tells its listeners of batches; counts how often it is closed."""

    def __init__(self) -> None:
        self.listeners, self.closed = list[Callable[[Tensor], None]](), 0

    def listen(self, listener: Callable[[Tensor], None]) -> None:
        self.listeners.append(listener)

    def collect(self, frames: int) -> None:
        for listener in self.listeners:
            listener(torch.empty(frames))

    def close(self) -> None:
        self.closed += 1


@pytest.fixture
def scholars(subject: Subject) -> tuple[Subject, list[tuple[Scholar, Experiences]]]:
    """The block with a meta-learner, and what was made of that."""
    made = list[tuple[Scholar, Experiences]]()

    def begun(seed: int) -> Any:  # noqa: ANN401
        del seed
        made.append((Scholar(), Experiences()))
        return made[-1]

    return replace(subject, meta=MetaLearner(3, begun)), made


def test_training_on_adds_what_the_stronger_push_adds(subject: Subject, tmp_path: Path) -> None:
    told = list[float]()
    found = evaluator().evaluate(subject, tmp_path, told.append)
    mass = np.linspace(0.5, 3.5, 4)
    for k, (grid, force) in enumerate(zip(found.grids, (1.0, 3.0, 5.0), strict=False)):
        np.testing.assert_allclose(grid.mean, expected(mass, force), rtol=1e-6)
        assert found.figures[f"return_after_{k}"] == pytest.approx(float(expected(mass, force).mean()), rel=1e-6)
    for gain, more in zip(found.gains, (2.0, 4.0), strict=True):
        for values in (gain.value, gain.low, gain.high):
            np.testing.assert_allclose(values, expected(mass, more), rtol=1e-6)
        assert not gain.doubtful.any()
    assert [found.figures[name] for name in ("helps_1", "helps_2", "hurts_1", "infeasible")] == [1.0, 1.0, 0.0, 0.0]
    assert [grid.over for grid in found.grids] == ["adaptations"] * 3 + ["contexts"]
    assert found.figures["correlation"] == pytest.approx(1.0)
    assert found.rows[1] == pytest.approx(
        {"block.mass": 0.5, "updates": 1.0, "return": float(expected(0.5, 3.0)), "gain": float(expected(0.5, 2.0))}
        | dict.fromkeys(("low", "high"), float(expected(0.5, 2.0))),
        rel=1e-6,
    )
    assert [each.name.partition("_")[0] for each in found.episodes] == ["task"] * 4
    assert found.episodes[0].undiscounted < found.episodes[1].undiscounted
    assert not found.ways
    assert told[-1] == 1.0


def test_updates_that_hurt_are_seen(subject: Subject, tmp_path: Path) -> None:
    def again(source: ContextSource, seed: int) -> tuple[Trainer, Policy]:
        del source, seed
        trainer = Weaker()
        return cast(Any, trainer), trainer

    found = evaluator().evaluate(replace(subject, again=again), tmp_path, print)
    assert (found.figures["hurts_1"], found.figures["helps_1"]) == (1.0, 0.0)
    np.testing.assert_allclose(found.gains[0].value, -expected(np.linspace(0.5, 3.5, 4), 2.0), rtol=1e-6)


def test_a_meta_learner_adapts_to_contexts_together_each_policy_in_its_own(
    scholars: tuple[Subject, list[tuple[Scholar, Experiences]]], tmp_path: Path
) -> None:
    subject, made = scholars
    found = evaluator().evaluate(subject, tmp_path, print)
    mass = np.linspace(0.5, 3.5, 4)
    for gain, updates in zip(found.gains, (1, 2), strict=True):
        np.testing.assert_allclose(gain.value, expected(mass, updates * mass), rtol=1e-6)
    assert len(made) == 3  # 8 adaptations, 3 at once
    assert all(one.heard == [0, 1] for one, _ in made)
    assert all(experience.closed == 1 for _, experience in made)


def test_fine_tuning_takes_the_updates_of_a_meta_learner(
    scholars: tuple[Subject, list[tuple[Scholar, Experiences]]], tmp_path: Path
) -> None:
    class FourMasses:
        def __init__(self, space: object) -> None:
            del space

        def sample(self, rngs: object) -> Array:
            del rngs
            return np.array([[1.0], [2.0], [3.0], [4.0]])

    tuned = FineTuneEvaluator(cast(Any, FourMasses), contexts=4, rounds=2, frames=1, episodes=2, seed=0)
    found = tuned.evaluate(scholars[0], tmp_path, print)
    rows = np.array([[row["jump_start"], row["asymptote"]] for row in found.rows], dtype=float)
    mass = np.arange(1.0, 5.0)
    np.testing.assert_allclose(rows, np.column_stack([expected(mass), expected(mass, 1.0 + 2.0 * mass)]), rtol=1e-6)
    np.testing.assert_array_equal(found.curves[0].at, [0, 20, 40])  # 60 for the three contexts of a group
    assert "2 rounds of 40 control steps together" in found.told


def test_groups_are_of_one_size_and_repeat_the_last() -> None:
    z = np.arange(5.0)[:, None]
    groups = list(in_groups(z, 3))
    assert [count for _, count in groups] == [3, 2]
    np.testing.assert_array_equal(groups[1][0][:, 0], [3.0, 4.0, 4.0])


def test_cells_at_the_bounds_are_inside_however_they_are_rounded() -> None:
    space = ContextSpace((Parameter("goal", "m", 0.0, -0.3, 0.3),))
    z = cells(space, context_axes(space, {"goal": [-2.0, 2.0, 41]}, 2, 1))
    assert z.max(where=z < 0.35, initial=0.0) > 0.3  # by 3e-16
    assert z[within(space, z), 0].round(9).tolist() == [-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3]


def test_intervals_are_those_of_students_t() -> None:
    values = np.random.default_rng(0).normal(3.0, 1.0, (4, 6))
    values[2, 1:], values[3] = np.nan, np.nan
    mean, low, high = t_intervals(values, 0.9)
    for row in (0, 1):
        wanted = stats.t.interval(0.9, 5, values[row].mean(), stats.sem(values[row]))
        np.testing.assert_allclose([low[row], high[row]], wanted)
        assert mean[row] == pytest.approx(values[row].mean())
    assert (mean[2], np.isnan(low[2])) == (values[2, 0], True)
    assert np.isnan([mean[3], low[3], high[3]]).all()


def test_cells_are_in_doubt_where_adaptations_disagree_and_unknown_where_infeasible() -> None:
    axis = ContextAxis("goal", "m", np.array([-1.0, 0.0, 1.0, 2.0]))
    gain = np.array([[-3.0, -2.9, -3.1], [5.0, -5.0, 0.3], [2.0, 2.1, 1.9], [np.nan] * 3])
    before = np.where(np.isnan(gain), np.nan, 10.0)
    inside = np.array([False, True, True, True])
    found = AdaptedReturns([axis], np.stack([before, before + gain], axis=-1), inside, 0.95).summed_up()
    assert found.gains[0].doubtful.tolist() == [False, True, False, True]
    assert [found.figures[name] for name in ("hurts_1", "helps_1", "infeasible")] == [1 / 3, 1 / 3, 0.25]
    assert found.figures["return_after_1_outside"] == pytest.approx(7.0)
    assert found.figures["gain_1_inside"] == pytest.approx((0.1 + 2.0) / 2)
    assert found.grids[0].title == "before the first update"
    np.testing.assert_allclose(found.grids[-1].mean, [10.0, 10.0 + (-3.0 + 0.1 + 2.0) / 3])
    assert np.isnan(float(found.rows[-1]["gain"]))


def test_numbers_that_say_nothing_are_refused(subject: Subject, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"evaluator\.repeats is 1; expected at least 2"):
        evaluator(repeats=1)
    with pytest.raises(
        ConfigError, match=r"evaluator\.frames is 4, less than a batch of 10 .* update 2 trains nothing"
    ):
        evaluator(frames=4).evaluate(subject, tmp_path, print)


def test_what_would_be_trained_on_in_contexts_of_its_own_is_refused(subject: Subject, tmp_path: Path) -> None:
    taught = replace(subject, domains=np.array([[1.0], [2.0]]))
    tuned = FineTuneEvaluator(partial(UniformRandomizer, ranges=None), 4, rounds=2, frames=20, episodes=2, seed=0)
    for each in (evaluator(), tuned):
        with pytest.raises(ConfigError, match=r"trained on the same 2 contexts throughout.*evaluator=unseen_domains"):
            each.evaluate(taught, tmp_path, print)
