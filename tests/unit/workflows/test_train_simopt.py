"""SimOpt from the command line, and what its run folder is good for."""

import json
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf
from settings import setting
from test_evaluate import job

from dr_lab.cli.arguments import compose_arguments
from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.errors import ConfigError
from dr_lab.evaluators.trained_run import subject_of
from dr_lab.physics.context_file import read_context
from dr_lab.randomizers.from_run import from_run
from dr_lab.randomizers.gaussian import GaussianRandomizer
from dr_lab.training.checkpoint import load

SMALL = ["env=furuta_balance", "env.task.time_limit=30", "threads=1", "episodes=8", "rollout_episodes=8", "frames=1024"]
LEARNT = ["randomizer=gaussian", "distribution_learner=simopt", "distribution_learner.samples=12"]
SOON = ["distribution_learner.warm_up=0", "distribution_learner.every=256", "distribution_learner.updates=1"]
SHORT = ["algorithm.batch_frames=256", "choice.episodes=2", "recorder.episodes=1"]
TARGET = [
    "target@distribution_learner.target=model",
    "+distribution_learner.target.context={arm.mass:0.13,coulomb_friction@arm.torque:0.001}",
]


@pytest.mark.slow
def test_a_learnt_gaussian_is_a_context_to_train_on(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    job("train", folder, [*SMALL, *LEARNT, *SOON, *SHORT, *TARGET])
    found, space = read_context(folder), setting("furuta_balance").space
    assert found.space.names == space.names
    assert (np.linalg.eigvalsh(found.covariance) > 0.0).all()
    again = from_run(space, str(folder), clip=True)
    np.testing.assert_allclose(again.moments()[0], found.mean)
    np.testing.assert_allclose(again.moments()[1], found.covariance, rtol=1e-9)
    model = instantiate(compose("compare", ["model=from_run", f"model.run={folder}"]).model, _convert_="all")
    np.testing.assert_allclose(model.space.nominal, space.clip(found.mean))
    report = json.loads((folder / "report.json").read_text("utf-8"))
    start, *_, last = report["ladder"]
    assert (start["iteration"], start["discrepancy"], start["context"]["arm.mass"]["mean"]) == (0, None, 0.125)
    assert last["context"]["arm.mass"]["mean"] == pytest.approx(found.mean[0], rel=1e-9)
    assert last["discrepancy"] > 0.0
    assert len(report["ladder"]) == 1 + 1024 // 256
    assert "iteration" in (folder / "report.md").read_text("utf-8")
    head, *rows = (folder / "metrics.csv").read_text("utf-8").splitlines()
    columns = dict(zip(head.split(","), rows[-1].split(","), strict=True))
    assert 0.0 < float(columns["divergence"]) <= 1.0 + 1e-6


def test_a_run_that_ends_before_it_learns_is_refused(tmp_path: Path) -> None:
    late = ["distribution_learner.warm_up=3", "distribution_learner.every=512"]
    with pytest.raises(ConfigError, match="frames is 1024, but the distribution is learned from control step 2048 on"):
        job("train", tmp_path / "run", [*SMALL, *LEARNT, *SHORT, *TARGET, *late])


def test_a_policy_is_played_where_the_logs_are_gone_that_its_distribution_was_learnt_from(tmp_path: Path) -> None:
    few = ["env.task.time_limit=30", "threads=1", "episodes=8", "rollout_episodes=8", "frames=256"]
    few += [f"distribution_learner.{each}" for each in ("rollouts=1", "samples=4", "updates=1", "every=256")]
    job("train", tmp_path / "run", ["experiment=simopt_furuta_logs", *few, *SHORT])
    path = tmp_path / "run" / "config.yaml"
    config = OmegaConf.load(path)
    config.distribution_learner.target.measurements.logs = [str(tmp_path / "nowhere" / "*.mcap")]
    OmegaConf.save(config, path)
    subject = subject_of(tmp_path / "run", partial(compose_arguments, folders=(shipped(),)), threads=1)
    left = load(tmp_path / "run" / "checkpoint.pt")["learner"]["randomizer"]["loc"]
    assert left.any()
    assert subject.trained_on is not None
    assert torch.equal(cast(GaussianRandomizer, subject.trained_on).loc, left)
