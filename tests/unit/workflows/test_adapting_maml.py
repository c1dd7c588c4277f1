"""A short run of MAML on nav2d from the command line, adapted by the evaluators as it was trained to be."""

import functools
import json
from pathlib import Path

import numpy as np
import pytest
from test_evaluate import evaluated, job

from dr_lab.algorithms.maml.maml import MAML
from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.folders import shipped
from dr_lab.collectors.play import play, undiscounted
from dr_lab.evaluators.evaluator import Subject
from dr_lab.evaluators.trained_run import subject_of
from dr_lab.trajectory import Array

SMALL = ["env=nav2d", "env.task.time_limit=10", "collector=lean", "threads=1", "episodes=12", "rollout_episodes=4"]
LEARNT = ["algorithm=maml", "algorithm.tasks=4", "algorithm.batch_frames=120", "frames=480", "checkpoint_every=240"]
SHOWN = ["choice.snapshots=3", "choice.episodes=2", "recorder.episodes=1"]
CELLS = "evaluator.axes={goal.x: [-1, 1, 3], goal.y: [0.3, 1, 2]}"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "maml"
    job("train", folder, [*SMALL, *LEARNT, *SHOWN])
    return folder


@pytest.fixture(scope="module")
def subject(run: Path) -> Subject:
    return subject_of(run, functools.partial(compose_arguments, folders=(shipped(),)), threads=1)


def adapted(subject: Subject, z: Array, updates: int, seed: int = 0) -> Array:
    """Returns of an episode in each context after so many updates."""
    adapting = subject.adapting(z, 1, seed)
    for _ in range(updates):
        adapting.update()
    returns = undiscounted(play(subject.slots(len(z), 0), adapting.policy, z))
    adapting.close()
    return returns


def test_the_last_policy_is_deployed_whatever_it_returns_before_it_is_adapted(run: Path) -> None:
    report = json.loads((run / "report.json").read_text("utf-8"))
    assert [each["frames"] for each in report["snapshots"]] == [report["chosen"]] == [report["frames"]]


def test_a_meta_learner_is_adapted_as_it_was_trained(subject: Subject) -> None:
    assert subject.together == 4
    z = np.array([[0.4, 0.0], [-0.4, 0.0], [0.0, 0.4], [0.0, -0.4]])
    before = undiscounted(play(subject.slots(4, 0), subject.policy, z))
    np.testing.assert_allclose(adapted(subject, z, 0), before, atol=1e-5)
    once = adapted(subject, z, 1)
    assert (np.abs(once - before) > 1e-4).all()
    np.testing.assert_array_equal(adapted(subject, z, 1), once)  # what one adaptation did, the next does not begin with
    assert (adapted(subject, z, 1, seed=1) != once).all()
    # Reversed contexts get the same tasks' episodes by other random numbers, but each policy stays with its context.
    assert np.argmin(np.abs(adapted(subject, z[::-1].copy(), 0)[0] - before)) == 3


@pytest.mark.slow
def test_the_table_of_adaptations_begins_with_the_returns_of_the_grid(run: Path, tmp_path: Path) -> None:
    few = ["evaluator.repeats=2", "evaluator.updates=2", "evaluator.episodes=1", "evaluator.shown=3"]
    report = evaluated(run, tmp_path / "adapted", "evaluator=adaptation", CELLS, *few)
    plain = evaluated(run, tmp_path / "grid", "evaluator=grid", CELLS, "evaluator.episodes=1")
    assert len(report.rows) == 6 * 3
    first = [float(row["return"] or "nan") for row in report.rows if row["updates"] == 0.0]
    np.testing.assert_allclose(first, [float(row["return"] or "nan") for row in plain.rows], rtol=1e-5)
    assert all(row["low"] < row["gain"] < row["high"] for row in report.rows if row["updates"])  # pyright: ignore
    assert {"gain_1", "gain_2", "hurts_1", "helps_2", "correlation", "gain_1_outside"} <= report.figures.keys()
    assert report.figures["infeasible"] == 0.0
    assert len(report.episodes) == 4
    assert (tmp_path / "adapted" / "review.rrd").stat().st_size > 0


def test_fine_tuning_a_meta_learner_takes_its_updates(run: Path, tmp_path: Path) -> None:
    few = ["evaluator.contexts=5", "evaluator.rounds=1", "evaluator.episodes=1"]
    report = evaluated(run, tmp_path / "tuned", "evaluator=fine_tune", *few)
    assert all(row["jump_start"] != row["asymptote"] for row in report.rows)


def test_what_is_chosen_is_a_meta_learner(subject: Subject) -> None:
    assert subject.meta is not None
    algorithm, experience = subject.meta.again(0)
    assert isinstance(algorithm, MAML)
    experience.close()
