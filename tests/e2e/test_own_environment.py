"""An environment and a machine of one's own, outside of the package, as docs/start.md shows them."""

import json
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from dr_lab.__main__ import main

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_robot"
SMALL = ("frames=2048", "episodes=16", "algorithm.batch_frames=1024", "algorithm.minibatch=128", "threads=1")
BENCH = ("evaluator=real_vs_sim", "target@evaluator.target=rig_bench", "evaluator.episodes=2", "hydra.run.dir=judged")


@pytest.fixture
def _forgotten() -> Iterator[None]:
    """Modules of the example are gone with its folder."""
    yield
    sys.modules.pop("rig_reach", None)


@pytest.mark.usefixtures("_forgotten")
def test_the_arm_of_the_example_is_trained_and_played(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(EXAMPLE, tmp_path / "robot")
    monkeypatch.chdir(tmp_path / "robot")
    monkeypatch.syspath_prepend(tmp_path / "robot")
    monkeypatch.setenv("DR_LAB_TRUST", "rig_reach")
    assert main(["train", "--config-dir", "mine", "env=rig_reach", *SMALL, "hydra.run.dir=policy"]) == 0
    assert main(["evaluate", "--config-dir", "mine", "run=policy", *BENCH]) == 0
    report = json.loads(Path("judged/report.json").read_text(encoding="utf-8"))
    # The elbow's dry friction, which the model lacks, shows in every episode.
    assert all(0.0 < row["elbow.rmse"] < 0.5 for row in report["rows"])
