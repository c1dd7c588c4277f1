"""Evaluators on a block that is pushed along a rail: x' grows by F h/m a step, so a return is h F/m · T (T + 1)/2."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import mujoco
import numpy as np
import pytest
from block_on_rail import BlockOnRail, constant
from numpy.typing import NDArray
from torch import Tensor

from dr_lab.collectors.collector import Policy
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.errors import ConfigError
from dr_lab.evaluators.evaluator import Subject
from dr_lab.evaluators.fine_tune import FineTuneEvaluator
from dr_lab.evaluators.grid import GridEvaluator
from dr_lab.evaluators.returns import ReturnsEvaluator
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.model import from_spec
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.training.trainer import Trainer
from dr_lab.trajectory import Array

STEP, STEPS = 0.01, 20
FEW: dict[str, Any] = {"confidence": 0.95, "resamples": 200, "seed": 0}
XML = f"""<mujoco model="block"><option timestep="{STEP}" integrator="Euler"/><worldbody><body name="block">
  <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-9 9"/></actuator></mujoco>"""
MASS = {"block.mass": {"target": "body.block.mass", "unit": "kg", "low": 0.5, "high": 4.0}}


class Push(BlockOnRail):
    """The mean velocity of every step is rewarded."""

    def observe(self, fields: Fields, values: Values) -> Array:
        del values
        return np.concatenate([fields["qpos"], fields["qvel"]], axis=1)

    def marker(self, fields: Fields) -> Array:
        return fields["qpos"].copy()

    def reward(self, change: Change) -> Array:
        return change.velocity[:, 0]


class Stronger:
    """Stands for a trainer of batches of 10: its policy pushes with 1 N more for every batch."""

    def __init__(self) -> None:
        self.frames, self.force, self.closed = 100, 1.0, False

    def close(self) -> None:
        self.closed = True

    def run(self, frames: int, watch: Callable[..., None]) -> None:
        del watch
        while self.frames < frames:
            self.frames, self.force = self.frames + 10, self.force + 1.0

    def __call__(self, observation: Tensor) -> Tensor:
        return constant(self.force)(observation)


class Fragile(Subject):
    """Returns F/m; below 1 kg a push beyond 3 N lets the block diverge, below 0.1 kg any."""

    def rollouts(self, episodes: int, seed: int, policy: Policy | None = None) -> Any:  # noqa: ANN401
        del episodes, seed
        return Pretended(cast(Stronger, policy))


class Pretended:
    def __init__(self, policy: Stronger) -> None:
        self.policy = policy

    def outcomes(self, z: Array) -> tuple[Array, NDArray[np.bool_]]:
        mass, force = z[:, 0], self.policy.force
        infeasible = (mass < 0.1) | ((mass < 1.0) & (force > 3.0))
        return np.where(infeasible, -10.0, force / mass), infeasible


class FiveMasses:
    def __init__(self, space: ContextSpace) -> None:
        del space

    def sample(self, rngs: object) -> Array:
        del rngs
        return np.array([[0.05], [0.5], [1.0], [2.0], [4.0]])


def again(source: ContextSource, seed: int) -> tuple[Trainer, Policy]:
    del source, seed
    trainer = Stronger()
    return cast(Any, trainer), trainer


@pytest.fixture(scope="module")
def subject() -> Subject:
    model = from_spec("block", mujoco.MjSpec.from_string(XML), MASS)
    task = Push(frame_skip=1, time_limit=STEPS)
    setting = Setting(
        name="block", model=model, task=task, show_context=False, infeasible_return=0.0, speed_limit=200.0
    )
    return Subject("pushed", setting, constant(1.0), again)


def expected(mass: Array | float, force: Array | float = 1.0) -> Array:
    return np.asarray(STEP * force / mass * STEPS * (STEPS + 1) / 2)


def test_a_grid_holds_the_return_of_every_cell(subject: Subject, tmp_path: Path) -> None:
    told: list[float] = []
    evaluator = GridEvaluator(axes={"block.mass": [0.5, 3.5, 4]}, count=9, episodes=2, parallel=3, seed=0)
    found = evaluator.evaluate(subject, tmp_path, told.append)
    (grid,) = found.grids
    np.testing.assert_allclose(grid.axes[0].values, [0.5, 1.5, 2.5, 3.5])
    np.testing.assert_allclose(grid.mean, expected(grid.axes[0].values), rtol=1e-6)
    np.testing.assert_allclose(grid.spread, 0.0, atol=1e-9)
    assert found.figures["best_return"] == pytest.approx(float(expected(0.5)))
    assert found.rows[1] == pytest.approx(
        {"block.mass": 1.5, "return": float(expected(1.5)), "std": 0.0, "diverged": 0.0}, abs=1e-6
    )
    assert told[-1] == 1.0


@pytest.mark.parametrize(("solved", "share", "lowest"), [(1.0, 0.5, 0.5), (0.1, 1.0, 0.5), (9.0, 0.0, np.nan)])
def test_a_grid_says_which_contexts_are_solved(
    subject: Subject, tmp_path: Path, solved: float, share: float, lowest: float
) -> None:
    evaluator = GridEvaluator({"block.mass": [0.5, 3.5, 4]}, count=9, episodes=1, parallel=4, seed=0, solved=solved)
    found = evaluator.evaluate(subject, tmp_path, print).figures  # returns of 4.2, 1.4, 0.84 and 0.6
    assert (found["solved"], found["lowest_solved"]) == pytest.approx((share, lowest), nan_ok=True)


def test_a_grid_over_every_parameter_takes_their_bounds(subject: Subject, tmp_path: Path) -> None:
    found = GridEvaluator(axes=None, count=3, episodes=1, parallel=2, seed=0).evaluate(subject, tmp_path, print)
    np.testing.assert_allclose(found.grids[0].axes[0].values, [0.5, 2.25, 4.0])


@pytest.mark.parametrize("axes", [None, {"block.mass": [0.5, 2.0, 2]}])
def test_a_machine_without_parameters_is_sent_to_training(
    axes: dict[str, list[float]] | None, subject: Subject, tmp_path: Path
) -> None:
    bare = replace(subject.setting, model=from_spec("block", mujoco.MjSpec.from_string(XML), {}))
    evaluator = GridEvaluator(axes=axes, count=2, episodes=1, parallel=1, seed=0)
    with pytest.raises(ConfigError, match=r"has no parameters to vary\. Train with some: env/context=…"):
        evaluator.evaluate(replace(subject, setting=bare), tmp_path, print)


def test_three_axes_are_refused(subject: Subject, tmp_path: Path) -> None:
    axes = {name: [0.0, 1.0, 2] for name in "abc"}
    with pytest.raises(ConfigError, match=r"one or two parameters.*'evaluator.axes=\{block.mass: \[.*, 2\]\}'"):
        GridEvaluator(axes=axes, count=2, episodes=1, parallel=1, seed=0).evaluate(subject, tmp_path, print)


@pytest.mark.parametrize("axis", [[1.0, 2.0, 1], [1.0, 2.0, np.inf], [1.0, np.inf, 3], [1.0, 2.0, 2.5]])
def test_an_axis_without_two_values_is_refused(axis: list[float], subject: Subject, tmp_path: Path) -> None:
    evaluator = GridEvaluator(axes={"block.mass": axis}, count=2, episodes=1, parallel=1, seed=0)
    with pytest.raises(
        ConfigError, match=rf"evaluator\.axes\.block\.mass is {re.escape(str(axis))}; expected \[lowest"
    ):
        evaluator.evaluate(subject, tmp_path, print)


def test_returns_over_a_distribution_are_those_of_its_contexts(subject: Subject, tmp_path: Path) -> None:
    near = partial(UniformRandomizer, ranges={"block.mass": [1.999, 2.001]})
    wide = partial(UniformRandomizer, ranges={"block.mass": [1.0, 4.0]})
    evaluator = ReturnsEvaluator(
        distributions={"near": near, "wide": wide}, contexts=200, parallel=50, **FEW, episodes=1
    )
    found = evaluator.evaluate(subject, tmp_path, print)
    first, second = found.rows
    assert first["iqm"] == pytest.approx(float(expected(2.0)), rel=1e-3)
    # E[1/m] over U(1, 4) is ln 4 / 3
    assert second["mean"] == pytest.approx(float(expected(1.0)) * np.log(4) / 3, rel=0.06)
    assert float(second["low"]) < float(second["iqm"]) < float(second["high"])
    assert float(second["worst_decile"]) == pytest.approx(float(expected(3.85)), rel=0.03)


def test_a_confidence_of_one_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"evaluator\.confidence is 1; expected a share between 0 and 1"):
        ReturnsEvaluator(distributions={}, contexts=1, episodes=1, parallel=1, confidence=1.0, resamples=1, seed=0)


def test_training_on_is_followed_from_jump_start_to_asymptote(subject: Subject, tmp_path: Path) -> None:
    near = partial(UniformRandomizer, ranges={"block.mass": [1.999, 2.001]})
    evaluator = FineTuneEvaluator(near, contexts=4, rounds=2, frames=20, episodes=2, seed=0)
    found = evaluator.evaluate(subject, tmp_path, print)
    assert found.figures["jump_start"] == pytest.approx(float(expected(2.0)), rel=1e-3)
    assert found.figures["asymptote"] == pytest.approx(float(expected(2.0, 5.0)), rel=1e-3)
    curve, infeasible = found.curves
    np.testing.assert_array_equal(curve.at, [0, 20, 40])
    assert curve.over == infeasible.over == "frames"
    assert not infeasible.value.any()
    np.testing.assert_allclose(curve.value / curve.value[0], [1.0, 3.0, 5.0], rtol=1e-6)


def test_the_curve_stands_at_the_control_steps_that_were_trained(subject: Subject, tmp_path: Path) -> None:
    near = partial(UniformRandomizer, ranges={"block.mass": [1.999, 2.001]})
    found = FineTuneEvaluator(near, contexts=1, rounds=2, frames=14, episodes=1, seed=0)
    curve = found.evaluate(subject, tmp_path, print).curves[0]
    np.testing.assert_array_equal(curve.at, [0, 20, 30])
    np.testing.assert_allclose(curve.value / curve.value[0], [1.0, 3.0, 4.0], rtol=1e-6)
    short = FineTuneEvaluator(near, contexts=1, rounds=2, frames=4, episodes=1, seed=0)
    with pytest.raises(
        ConfigError, match=r"evaluator\.frames is 4, less than a batch of 10 .* update 2 trains nothing"
    ):
        short.evaluate(subject, tmp_path, print)


def test_jump_start_and_asymptote_are_of_the_same_contexts_where_one_diverges_while_training_on(
    subject: Subject, tmp_path: Path
) -> None:
    fragile = Fragile(subject.name, subject.setting, subject.policy, subject.again)
    evaluator = FineTuneEvaluator(cast(Any, FiveMasses), contexts=5, rounds=2, frames=20, episodes=1, seed=0)
    found = evaluator.evaluate(fragile, tmp_path, print)
    typical, infeasible = found.curves
    # Pushed with 1, 3 and 5 N: of the second mass there is no last round, of the first none at all.
    each = np.mean([1.0, 1.0 / 2.0, 1.0 / 4.0])
    np.testing.assert_allclose(typical.value, each * np.array([1.0, 3.0, 5.0]))
    np.testing.assert_allclose(infeasible.value, [0.2, 0.2, 0.4])
    wanted = {"jump_start": each, "asymptote": 5.0 * each, "infeasible": 0.2, "infeasible_after": 0.4}
    assert found.figures == pytest.approx(wanted)
    assert found.rows[1]["jump_start"] == 2.0
    assert np.isnan(float(found.rows[1]["asymptote"]))


def test_every_context_has_a_trainer_with_a_seed_of_its_own_that_is_closed(subject: Subject, tmp_path: Path) -> None:
    trainers, seeds = list[Stronger](), list[int]()

    def watched(source: ContextSource, seed: int) -> tuple[Trainer, Policy]:
        found = again(source, seed)
        trainers.append(cast(Stronger, found[1]))
        seeds.append(seed)
        return found

    near = partial(UniformRandomizer, ranges={"block.mass": [1.999, 2.001]})
    for seed in (0, 1):
        evaluator = FineTuneEvaluator(near, contexts=2, rounds=1, frames=10, episodes=1, seed=seed)
        evaluator.evaluate(replace(subject, again=watched), tmp_path, print)
    assert all(trainer.closed for trainer in trainers)
    assert len({0, 1, *seeds}) == 6  # neither among themselves, nor those that the returns are measured with


class Lucky(Subject):
    """Every second episode returns 1, the others 0, whatever the context; below 1 kg the latter diverge with −10."""

    def rollouts(self, episodes: int, seed: int, policy: Policy | None = None) -> Any:  # noqa: ANN401
        del episodes, seed, policy
        return Coin()


class Coin:
    def outcomes(self, z: Array) -> tuple[Array, NDArray[np.bool_]]:
        luck = np.arange(len(z)) % 2 == 0
        infeasible = ~luck & (z[:, 0] < 1.0)
        return np.where(infeasible, -10.0, luck), infeasible


def test_luck_in_single_episodes_is_in_the_tail_of_episodes_not_of_contexts(subject: Subject, tmp_path: Path) -> None:
    lucky = Lucky(subject.name, subject.setting, subject.policy, subject.again)
    wide = partial(UniformRandomizer, ranges={"block.mass": [1.0, 4.0]})
    found = ReturnsEvaluator(distributions={"wide": wide}, contexts=20, parallel=50, **FEW, episodes=4).evaluate(
        lucky, tmp_path, print
    )
    assert found.figures == {"wide.iqm": 0.5, "wide.worst_decile": 0.5, "wide.cvar": 0.0}


def test_a_cell_with_a_diverged_episode_counts_what_the_policy_got(subject: Subject, tmp_path: Path) -> None:
    lucky = Lucky(subject.name, subject.setting, subject.policy, subject.again)
    evaluator = GridEvaluator(axes={"block.mass": [0.5, 2.0, 2]}, count=2, episodes=2, parallel=4, seed=0)
    found = evaluator.evaluate(lucky, tmp_path, print)
    assert [row["return"] for row in found.rows] == [-4.5, 0.5]
    assert [row["diverged"] for row in found.rows] == [0.5, 0.0]
    wanted = {"mean_return": -2.0, "worst_return": -4.5, "best_return": 0.5, "infeasible": 0.0, "diverged": 0.25}
    assert found.figures == wanted
    assert "An episode that diverges counts with the return that the task declares" in found.told
