"""A training run that is killed at random moments and continued each time ends as if nothing had happened."""

import csv
import random
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import pytest

COMMAND = [sys.executable, "-m", "dr_lab", "train", "episodes=8", "checkpoint_every=1", "threads=1"]
PPO = (
    *("frames=20480", "algorithm.batch_frames=256", "algorithm.minibatch=64", "algorithm.epochs=2"),
    "rollout_episodes=4",
)
LSDR = (*PPO, "experiment=lsdr_hopper_torso_small", "distribution_learner.contexts=4")
ADR = (*PPO, "experiment=adr_hopper_mass", "distribution_learner.svpg.count=3", "distribution_learner.svpg.proposals=2")
META_ADR = ("frames=64000", "experiment=meta_adr_nav2d", "algorithm.tasks=4", "distribution_learner.svpg.count=2")

SIMOPT = (
    *(*PPO, "experiment=simopt_furuta", "distribution_learner.samples=20", "distribution_learner.updates=2"),
    *("distribution_learner.warm_up=0", "distribution_learner.every=512", "env.task.time_limit=50"),
)
WHOLE = ("frames=20480", "env=furuta", "env.task.time_limit=32", "algorithm.batch_frames=256")
DIDOR = (*WHOLE, "algorithm=didor", "algorithm.teacher_frames=10240", "algorithm.teachers.count=4")
ENSEMBLE = (*WHOLE, "algorithm=ensemble", "algorithm.teachers.count=4")
P2PDRL = (*WHOLE, "algorithm=p2pdrl")


def start(learner: Sequence[str], folder: Path, *more: str) -> "subprocess.Popen[bytes]":
    return subprocess.Popen([*COMMAND, *learner, f"hydra.run.dir={folder}", *more], stdout=subprocess.DEVNULL)


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "metrics.csv").open(encoding="utf-8") as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("learner", "kills"),
    [(LSDR, 10), (ADR, 5), (META_ADR, 5), (SIMOPT, 5), (DIDOR, 5), (ENSEMBLE, 5), (P2PDRL, 5)],
    ids=["lsdr", "adr", "meta_adr", "simopt", "didor", "ensemble", "p2pdrl"],
)
def test_ends_as_if_nothing_had_happened(learner: Sequence[str], kills: int, tmp_path: Path) -> None:
    assert start(learner, tmp_path / "whole").wait() == 0
    moments, last = random.Random(0), None
    for number in range(kills):
        folder = tmp_path / f"part_{number}"
        run = start(learner, folder, *([] if last is None else [f"resume={last}"]))
        while run.poll() is None and not (folder / "checkpoint.pt").is_file():
            time.sleep(0.01)
        time.sleep(moments.uniform(0.0, 0.5))
        run.send_signal(signal.SIGKILL)
        run.wait()
        last = folder
    end = tmp_path / "end"
    assert start(learner, end, f"resume={last}").wait() == 0
    assert rows(end) == rows(tmp_path / "whole")
