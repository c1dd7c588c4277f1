"""Sweeps and studies whose driver is killed, doubled, interrupted or short of disk: the same command completes them."""

import json
import os
import random
import signal
import time
from pathlib import Path

import optuna
import pytest
import yaml
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from probe_sweeps import Sweeps, completed, table

JOBS = ("value=1,2,3,4,5,6", "seconds=0.2")
STUDY = (
    *("hydra/sweeper=study", "hydra.sweeper.objective=[score]", "hydra.sweeper.directions=[minimize]"),
    *("value=interval(0,6)", "size=int(interval(1,9))", "seconds=0.1"),
)
PROMPT = 10.0  # s; a tenth of it on a quiet machine


@pytest.fixture
def sweeps(tmp_path: Path) -> Sweeps:
    return Sweeps(tmp_path)


def killed_at(sweeps: Sweeps, folder: Path, moment: float, *arguments: str) -> None:
    """SIGKILL a driver some seconds after a job of its own began."""
    before = {path.stat().st_ino for path in folder.glob("*/status.json")}
    process = sweeps.start(*arguments, f"hydra.sweep.dir={folder}")
    while process.poll() is None and {path.stat().st_ino for path in folder.glob("*/status.json")} <= before:
        time.sleep(0.01)
    time.sleep(moment)
    process.send_signal(signal.SIGKILL)
    process.communicate()


def kill_and_complete(sweeps: Sweeps, folder: Path, moments: list[float], *arguments: str) -> None:
    """Kill the same command again and again, then let it end; what was completed is never touched again."""
    done: dict[str, tuple[int, str]] = {}
    for moment in moments:
        killed_at(sweeps, folder, moment, *arguments)
        now = completed(folder)
        assert {number: now[number] for number in done} == done
        done = dict(now)
    last = sweeps.run(*arguments, f"hydra.sweep.dir={folder}")
    assert last.returncode == 0, last.stderr
    now = completed(folder)
    assert {number: now[number] for number in done} == done


def sweep_survives(sweeps: Sweeps, tmp_path: Path, moments: list[float]) -> None:
    kill_and_complete(sweeps, tmp_path / "killed", moments, *JOBS)
    assert sweeps.run(*JOBS, "hydra.sweep.dir=whole").returncode == 0
    assert table(tmp_path / "killed") == table(tmp_path / "whole")
    names = {path.name for path in (tmp_path / "whole/0").iterdir()}
    for number in range(6):
        left = {path.name for path in (tmp_path / f"killed/{number}").iterdir()}
        assert {name for name in left if not name.startswith(".status.")} >= names


def study_survives(sweeps: Sweeps, tmp_path: Path, moments: list[float], trials: int) -> None:
    search = (*STUDY, f"hydra.sweeper.n_trials={trials}")
    kill_and_complete(sweeps, tmp_path / "killed", moments, *search)
    assert sweeps.run(*search, "hydra.sweep.dir=whole").returncode == 0
    assert table(tmp_path / "killed") == table(tmp_path / "whole")
    study = optuna.load_study(
        study_name="study", storage=JournalStorage(JournalFileBackend(str(tmp_path / "killed/study.journal")))
    )
    assert [trial.state.name for trial in study.trials] == ["COMPLETE"] * trials
    [best] = yaml.safe_load((tmp_path / "killed/best.yaml").read_text(encoding="utf-8"))
    assert best["objective"] == {"score": study.best_value}
    assert best["trial"] == study.best_trial.number


def test_killed_sweep(sweeps: Sweeps, tmp_path: Path) -> None:
    sweep_survives(sweeps, tmp_path, [0.1, 0.7])


def test_killed_study(sweeps: Sweeps, tmp_path: Path) -> None:
    study_survives(sweeps, tmp_path, [0.25], trials=3)


@pytest.mark.slow
def test_sweep_killed_at_twenty_random_moments(sweeps: Sweeps, tmp_path: Path) -> None:
    moments = random.Random(0)
    sweep_survives(sweeps, tmp_path, [moments.uniform(0.0, 0.25) for _ in range(20)])


@pytest.mark.slow
def test_study_killed_at_twenty_random_moments(sweeps: Sweeps, tmp_path: Path) -> None:
    moments = random.Random(1)
    study_survives(sweeps, tmp_path, [moments.uniform(0.0, 0.3) for _ in range(20)], trials=25)


def test_two_sweeps_in_one_folder_then_ctrl_c(sweeps: Sweeps, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "swept"
    arguments = ("value=1,2", "seconds=60", "hydra.sweep.dir=swept")
    first = sweeps.start(*arguments)
    while first.poll() is None and not (folder / "0/status.json").is_file():
        time.sleep(0.01)
    assert sweeps.here(monkeypatch, *arguments) == 2
    first.send_signal(signal.SIGINT)
    pressed = time.monotonic()
    _, told = first.communicate(timeout=60)
    assert time.monotonic() - pressed < PROMPT
    assert first.returncode == 130
    assert told.strip() == "dr-lab: interrupted."
    assert [row["status"] for row in table(folder)] == ["unfinished", "waiting"]


def test_full_disk(sweeps: Sweeps, tmp_path: Path) -> None:
    arguments = ("value=1,2", "size=10000", "hydra.sweep.dir=swept")
    nothing = sweeps.run(*arguments, PROBE_FILE_LIMIT="10")
    assert nothing.returncode == 2
    assert "Cannot write" in nothing.stderr
    assert not list((tmp_path / "swept").glob("*/"))
    half = sweeps.run(*arguments, PROBE_FILE_LIMIT="9000")
    assert half.returncode == 2
    assert "Of 2 jobs: 2 failed." in half.stderr
    assert "filling.txt: File too large" in half.stderr
    assert sweeps.run(*arguments).returncode == 0
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed", "completed"]


def test_clock_that_jumps(sweeps: Sweeps, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files from the future and from 1970 change nothing: what is done is read, not dated."""
    (sweeps.trouble / "fails_2").touch()
    assert sweeps.here(monkeypatch, "value=1,2", "hydra.sweep.dir=swept") == 2
    done = completed(tmp_path / "swept")
    for at, path in enumerate(sorted((tmp_path / "swept").rglob("*"))):
        os.utime(path, (at % 2 * 4e9, at % 2 * 4e9))
    (sweeps.trouble / "fails_2").unlink()
    assert sweeps.here(monkeypatch, "value=1,2", "hydra.sweep.dir=swept") == 0
    assert completed(tmp_path / "swept")["0"] == done["0"]
    seconds = json.loads((tmp_path / "swept/1/status.json").read_text(encoding="utf-8"))["seconds"]
    assert 0.0 <= seconds < 60.0


@pytest.mark.slow
def test_worker_that_dies_takes_no_other_job_with_it(sweeps: Sweeps, tmp_path: Path) -> None:
    """joblib loses what waits for a broken pool; those jobs are handed over again."""
    arguments = ("value=1,2,3,4", "hydra/launcher=cores", "hydra.launcher.n_jobs=1", "hydra.sweep.dir=swept")
    (sweeps.trouble / "dies_2").touch()
    died = sweeps.run(*arguments)
    assert died.returncode == 2
    assert "Of 4 jobs: 1 died." in died.stderr
    (sweeps.trouble / "dies_2").unlink()
    assert sweeps.run(*arguments).returncode == 0
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed"] * 4


@pytest.mark.slow
def test_worker_that_outlives_its_killed_driver(sweeps: Sweeps, tmp_path: Path) -> None:
    arguments = ("value=1,2", "seconds=8", "hydra/launcher=cores", "hydra.launcher.n_jobs=2")
    kill_and_complete(sweeps, tmp_path / "swept", [1.0], *arguments)
    reports = [json.loads((tmp_path / f"swept/{n}/report.json").read_text(encoding="utf-8")) for n in range(2)]
    assert [report["score"] for report in reports] == [4.0, 1.0]
