"""Goals on opposite sides interfere wholly, the same goal not at all, whatever the noise of few episodes."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from blocks_with_goals import gaussian, subject, without_noise

from dr_lab.algorithms.reinforce.critic_baseline import CriticBaseline
from dr_lab.algorithms.reinforce.mean_baseline import MeanBaseline
from dr_lab.errors import ConfigError, DataError
from dr_lab.evaluators.gradient_interference import GradientInterferenceEvaluator
from dr_lab.evaluators.policy_gradients import spread_over
from dr_lab.networks.critic import Critic


def evaluator(**changes: Any) -> GradientInterferenceEvaluator:  # noqa: ANN401
    numbers: dict[str, Any] = {
        "axes": None,
        "count": 3,
        "snapshots": 4,
        "episodes": 200,
        "parallel": 50,
        "baseline": MeanBaseline(),
        "gamma": 1.0,
        "confidence": 0.95,
        "resamples": 200,
        "seed": 0,
    }
    return GradientInterferenceEvaluator(**numbers | changes)


def test_opposite_goals_interfere_and_goals_on_one_side_help(tmp_path: Path) -> None:
    told: list[float] = []
    axes = {"goal.side": [-1.0, 1.0, 4]}  # −1, −1/3, 1/3, 1
    found = evaluator(axes=axes).evaluate(subject(gaussian()), tmp_path, told.append)
    for row in found.rows:
        a, b = float(row["goal.side a"]), float(row["goal.side b"])
        wanted = np.sign(a * b)
        assert row["sign"] == wanted
        assert float(row["corrected"]) == pytest.approx(wanted, abs=0.1)
        if a != b:
            assert float(row["low"]) - 0.02 <= wanted <= float(row["high"]) + 0.02
        assert np.sign(float(row["cosine"])) == wanted
    assert found.figures == pytest.approx(
        {"share_interfering": 4 / 6, "share_helping": 2 / 6, "share_in_doubt": 0.0, "share_told_from_noise": 1.0}
    )
    raw, corrected = found.matrices
    assert raw.title == "cosine after 100 control steps"
    assert corrected.title == "cosine without noise after 100 control steps"
    np.testing.assert_allclose(raw.axis.values, [-1.0, -1 / 3, 1 / 3, 1.0])
    assert not raw.doubtful.any()
    assert told[-1] == 1.0
    assert found.units == {"goal.side a": "1", "goal.side b": "1"}


def test_a_goal_that_rewards_nothing_is_neither_helped_nor_harmed(tmp_path: Path) -> None:
    found = evaluator(episodes=20).evaluate(subject(gaussian()), tmp_path, print)
    (still,) = [row for row in found.rows if row["goal.side a"] == row["goal.side b"] == 0.0]
    assert np.isnan(float(still["corrected"]))
    beside = [row for row in found.rows if 0.0 in (row["goal.side a"], row["goal.side b"])]
    assert np.isnan([float(row["sign"]) for row in beside]).all()
    assert found.matrices[0].doubtful.sum() == 5
    assert found.figures == {  # of −1 and 1, the only ones with a gradient
        "share_interfering": 1.0, "share_helping": 0.0, "share_in_doubt": 0.0, "share_told_from_noise": 1.0
    }  # fmt: skip


def test_policies_of_all_of_the_training_are_compared_the_newest_first(tmp_path: Path) -> None:
    found = evaluator(episodes=4, snapshots=2).evaluate(subject(*[gaussian() for _ in range(5)]), tmp_path, print)
    assert list(dict.fromkeys(row["frames"] for row in found.rows)) == [500.0, 300.0]
    assert found.matrices[0].title == "cosine after 500 control steps"
    assert [spread_over(range(n), 4) for n in (10, 4, 2)] == [[2, 4, 7, 9], [0, 1, 2, 3], [0, 1]]


def test_what_cannot_be_compared_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"evaluator=gradient_interference asks how likely .* algorithm=reinforce"):
        evaluator().evaluate(subject(without_noise()), tmp_path, print)
    with pytest.raises(DataError, match=r"Run run has kept no policy yet"):
        evaluator().evaluate(subject(), tmp_path, print)
    axes = {"goal.side": [-1.0, 1.0, 2], "other": [0.0, 1.0, 2]}
    with pytest.raises(ConfigError, match=r"draws one parameter; here it is 2"):
        evaluator(axes=axes).evaluate(subject(gaussian()), tmp_path, print)
    with pytest.raises(ConfigError, match=r"evaluator\.confidence is 1; expected a share between 0 and 1"):
        evaluator(confidence=1.0)


def test_a_baseline_that_has_to_learn_first_is_refused(tmp_path: Path) -> None:
    made = partial(Critic, hidden=[], activation="tanh")
    critic = CriticBaseline(made, seed=0, epochs=1, minibatch=1, rate=1.0, adam_epsilon=0.0)
    with pytest.raises(ConfigError, match=r"baseline is CriticBaseline, .* Give baseline@evaluator\.baseline=mean"):
        evaluator(baseline=critic).evaluate(subject(gaussian()), tmp_path, print)
