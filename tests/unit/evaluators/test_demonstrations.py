"""Demonstrations hold what was seen and done, and nothing that diverged."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_evaluators import FEW, expected, subject

from dr_lab.errors import DataError
from dr_lab.evaluators import demonstrations
from dr_lab.evaluators.demonstrations import DemonstrationsEvaluator
from dr_lab.evaluators.evaluator import Subject
from dr_lab.recorders.episode import Episode
from dr_lab.training.recorded import record

__all__ = ["subject"]


def test_demonstrations_are_kept_with_what_was_seen_and_done(subject: Subject, tmp_path: Path) -> None:
    evaluator = DemonstrationsEvaluator(context={"block.mass": 4.0}, episodes=3, **FEW)
    found = evaluator.evaluate(subject, tmp_path, print)
    assert found.figures["iqm"] == pytest.approx(float(expected(4.0)))
    assert [row["return"] for row in found.rows] == pytest.approx([float(expected(4.0))] * 3)
    for episode in found.episodes:
        assert episode.context == {"block.mass": (4.0, "kg")}
        np.testing.assert_allclose(episode.observation, np.hstack([episode.qpos, episode.qvel]), atol=1e-6)
        np.testing.assert_array_equal(episode.action, 1.0)


def test_demonstrations_that_diverge_are_left_out(
    subject: Subject, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def diverging(*given: Any) -> list[Episode]:  # noqa: ANN401
        first, *others = record(*given)
        return [replace(first, ended="infeasible"), *others]

    monkeypatch.setattr(demonstrations, "record", diverging)
    found = DemonstrationsEvaluator(context=None, episodes=4, **FEW).evaluate(subject, tmp_path, print)
    assert [each.name for each in found.episodes] == ["episode_2", "episode_3", "episode_4"]
    assert [row["ended"] for row in found.rows] == ["infeasible", "truncated", "truncated", "truncated"]
    assert found.figures["infeasible"] == 0.25
    assert "3 are kept" in found.told


def test_a_context_that_does_not_compile_gives_no_demonstrations(subject: Subject, tmp_path: Path) -> None:
    evaluator = DemonstrationsEvaluator(context={"block.mass": -1.0}, episodes=2, **FEW)
    with pytest.raises(DataError, match=r"All 2 episodes of run pushed in the context block\.mass = -1 are infeasible"):
        evaluator.evaluate(subject, tmp_path, print)
