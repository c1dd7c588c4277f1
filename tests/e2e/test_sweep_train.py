"""Sweeps of training: a job whose process was killed goes on at its checkpoint, as if it had not stopped."""

import csv
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from dr_lab.sweeps.table import TABLE_FILE

COMMAND = [
    *(sys.executable, "-m", "dr_lab", "train", "-m", "env=furuta_balance", "frames=1024", "algorithm.batch_frames=128"),
    *("algorithm.minibatch=64", "algorithm.epochs=2", "episodes=8", "recorder.episodes=1"),
    *("checkpoint_every=1", "threads=1", "seed=0,1"),
]


def start(folder: Path) -> "subprocess.Popen[bytes]":
    return subprocess.Popen([*COMMAND, f"hydra.sweep.dir={folder}"], stdout=subprocess.DEVNULL)


def metrics(folder: Path) -> list[dict[str, str]]:
    with (folder / "metrics.csv").open(encoding="utf-8") as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


@pytest.mark.slow
def test_goes_on_at_the_checkpoint(tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    assert (
        subprocess.run([*COMMAND, f"hydra.sweep.dir={whole}"], check=False, stdout=subprocess.DEVNULL).returncode == 0
    )
    driver = subprocess.Popen([*COMMAND, f"hydra.sweep.dir={killed}"], stdout=subprocess.DEVNULL)
    while driver.poll() is None and not (killed / "1/checkpoint.pt").is_file():
        time.sleep(0.01)
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    first = (killed / "0/checkpoint.pt").stat().st_ino
    assert not (killed / "1/report.json").is_file()
    assert (
        subprocess.run([*COMMAND, f"hydra.sweep.dir={killed}"], check=False, stdout=subprocess.DEVNULL).returncode == 0
    )
    assert (killed / "0/checkpoint.pt").stat().st_ino == first
    for seed in range(2):
        assert metrics(killed / str(seed)) == metrics(whole / str(seed))
    with (killed / TABLE_FILE).open(encoding="utf-8") as file:
        assert [(row["seed"], row["status"]) for row in csv.DictReader(file)] == [
            ("0", "completed"),
            ("1", "completed"),
        ]
