"""Curvature of a return with a closed form: the squared velocity after one push costs."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from blocks_with_goals import STEP, XML, Towards, gaussian, subject, without_noise

from dr_lab.algorithms.reinforce.mean_baseline import MeanBaseline
from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change
from dr_lab.errors import ConfigError, DataError
from dr_lab.evaluators.curvature import CurvatureEvaluator
from dr_lab.evaluators.statistics import mean_interval
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.normaliser import NoNormaliser
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array

GAIN, LOG_STD = 9.0 * STEP, -1.5  # v = GAIN·u after a step, u ~ N(b, σ²)
# L = GAIN²(b² + σ²), and the weight of an observation that is 0 does nothing.
WANTED = [2 * GAIN**2, 4 * GAIN**2 * np.exp(2 * LOG_STD), 0.0]


@dataclass(frozen=True, kw_only=True)
class Still(Towards):
    """Velocity costs."""

    def reward(self, change: Change) -> Array:
        return -(change.fields["qvel"][:, 0] ** 2)


def still() -> Setting:
    model, task = from_spec("block", mujoco.MjSpec.from_string(XML), {}), Still(frame_skip=1, time_limit=1)
    return Setting(name="still", model=model, task=task, show_context=False, infeasible_return=-99.0)


def actor() -> GaussianActor:
    made = GaussianActor(1, np.array([-9.0]), np.array([9.0]), 0, NoNormaliser, [], "tanh", log_std=LOG_STD)
    made.body.weights[0].data.zero_()
    return made


def evaluator(**changes: Any) -> CurvatureEvaluator:  # noqa: ANN401
    numbers: dict[str, Any] = {
        "eigenvalues": 2,
        "snapshots": 4,
        "reach": 0.2,
        "steps": 5,
        "episodes": 3_000,
        "parallel": 1_000,
        "baseline": MeanBaseline(),
        "gamma": 1.0,
        "confidence": 0.99,
        "resamples": 300,
        "seed": 0,
    }
    return CurvatureEvaluator(**numbers | changes)


def test_both_ends_of_the_spectrum_are_those_of_the_closed_form(tmp_path: Path) -> None:
    told: list[float] = []
    found = evaluator().evaluate(subject(actor(), setting=still()), tmp_path, told.append)
    for row, wanted in zip(found.rows, WANTED, strict=True):
        assert float(row["low"]) - 1e-9 <= wanted <= float(row["high"]) + 1e-9
        assert float(row["eigenvalue"]) == pytest.approx(wanted, abs=0.1)
    assert found.figures["largest.curvature"] == found.rows[0]["curvature"]
    assert found.figures["smallest.eigenvalue"] == pytest.approx(0.0, abs=1e-9)
    assert told[-1] == 1.0


@pytest.mark.slow
def test_along_an_eigenvector_the_return_bends_as_it_says(tmp_path: Path) -> None:
    found = evaluator().evaluate(subject(actor(), setting=still()), tmp_path, print)
    with (tmp_path / "along.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["along"] == "largest eigenvalue"]
    distance, played, surrogate = (
        np.array([float(row[key]) for row in rows]) for key in ("distance", "return", "surrogate")
    )
    np.testing.assert_allclose(distance, [-0.2, -0.1, 0.0, 0.1, 0.2], atol=1e-12)
    wanted = -(GAIN**2) * (distance**2 + np.exp(2 * LOG_STD))
    np.testing.assert_allclose(played, wanted, atol=5e-3)
    np.testing.assert_allclose(surrogate, wanted, atol=1e-2)
    assert surrogate[2] == pytest.approx(played[2])
    assert [grid.title for grid in found.grids] == ["largest eigenvalue", "smallest eigenvalue"]
    np.testing.assert_allclose(found.grids[0].mean, played)


@pytest.mark.slow
def test_noise_makes_eigenvalues_and_not_the_curvature_on_other_episodes(tmp_path: Path) -> None:
    # A reward that is linear in the action bends nowhere.
    found = [
        evaluator(episodes=40, steps=3, seed=seed).evaluate(subject(gaussian()), tmp_path, print).rows[0]
        for seed in range(8)
    ]
    eigenvalue, curvature = (np.array([float(row[key]) for row in found]) for key in ("eigenvalue", "curvature"))
    assert eigenvalue.min() > 0.0
    assert abs(curvature.mean()) < 3.0 * curvature.std() / np.sqrt(7)
    assert abs(curvature.mean()) < 0.5 * eigenvalue.mean()


def test_the_interval_of_a_mean_is_that_of_its_standard_error() -> None:
    values = np.random.default_rng(0).normal(3.0, 2.0, 400)
    found = mean_interval(values, 0.95, 4_000, seed=0)
    assert found.value == values.mean()
    assert found.high - found.low == pytest.approx(2 * 1.96 * values.std() / 20.0, rel=0.06)


def test_what_has_no_curvature_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"evaluator=curvature asks how likely an action is"):
        evaluator().evaluate(subject(without_noise()), tmp_path, print)
    with pytest.raises(DataError, match=r"Run run has kept no policy yet"):
        evaluator().evaluate(subject(), tmp_path, print)
    with pytest.raises(ConfigError, match=r"evaluator\.reach is 0; expected a number above 0"):
        evaluator(reach=0.0)
    with pytest.raises(ConfigError, match=r"evaluator\.reach is inf; expected a finite number"):
        evaluator(reach=np.inf)
    with pytest.raises(ConfigError, match=r"evaluator\.steps is 4; expected an odd number"):
        evaluator(steps=4)
