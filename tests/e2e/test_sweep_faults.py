"""Sweeps and studies whose driver is killed, doubled, interrupted or short of disk: the same command completes them."""

import json
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
FEW = ("value=1,2,3", "seconds=0.2")
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
    process.wait()


def kill_and_complete(sweeps: Sweeps, folder: Path, moments: list[float], *arguments: str) -> None:
    """Kill the same command again and again, then let it end; what was completed is never touched again."""
    done: dict[str, tuple[int, str]] = {}
    for moment in moments:
        killed_at(sweeps, folder, moment, *arguments)
        now = completed(folder)
        assert {number: now[number] for number in done} == done
        done = dict(now)
    assert sweeps.run(*arguments, f"hydra.sweep.dir={folder}") == 0, sweeps.told()
    now = completed(folder)
    assert {number: now[number] for number in done} == done
    assert not list(folder.rglob(".s*.*.json"))  # half-written


def require_whole_study(folder: Path, trials: int) -> None:
    study = optuna.load_study(
        study_name="study", storage=JournalStorage(JournalFileBackend(str(folder / "study.journal")))
    )
    assert [trial.state.name for trial in study.trials] == ["COMPLETE"] * trials
    [best] = yaml.safe_load((folder / "best.yaml").read_text(encoding="utf-8"))
    assert best["objective"] == {"score": study.best_value}
    assert best["trial"] == study.best_trial.number


@pytest.mark.slow
def test_home_that_cannot_be_written(sweeps: Sweeps, tmp_path: Path) -> None:
    nowhere = dict.fromkeys(("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"), "/proc/nothing")  # not even by root
    assert sweeps.run("value=1,2", "seconds=0", f"hydra.sweep.dir={tmp_path / 'swept'}", **nowhere) == 0, sweeps.told()
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed"] * 2


def test_killed_sweep(sweeps: Sweeps, tmp_path: Path) -> None:
    kill_and_complete(sweeps, tmp_path / "killed", [0.1, 0.3], *FEW)
    rows = [(row["number"], row["folder"], row["status"], row["value"]) for row in table(tmp_path / "killed")]
    assert rows == [(str(at), str(at), "completed", str(at + 1)) for at in range(3)]


@pytest.mark.slow
def test_killed_study(sweeps: Sweeps, tmp_path: Path) -> None:
    kill_and_complete(sweeps, tmp_path / "killed", [0.25], *STUDY, "hydra.sweeper.n_trials=3")
    require_whole_study(tmp_path / "killed", 3)


@pytest.mark.slow
def test_sweep_killed_at_twenty_random_moments(sweeps: Sweeps, tmp_path: Path) -> None:
    moments = random.Random(0)
    kill_and_complete(sweeps, tmp_path / "killed", [moments.uniform(0.0, 0.25) for _ in range(20)], *JOBS)
    assert sweeps.run(*JOBS, "hydra.sweep.dir=whole") == 0
    assert table(tmp_path / "killed") == table(tmp_path / "whole")


@pytest.mark.slow
def test_study_killed_at_twenty_random_moments(sweeps: Sweeps, tmp_path: Path) -> None:
    moments = random.Random(1)
    search = (*STUDY, "hydra.sweeper.n_trials=25")
    kill_and_complete(sweeps, tmp_path / "killed", [moments.uniform(0.0, 0.3) for _ in range(20)], *search)
    require_whole_study(tmp_path / "killed", 25)
    assert sweeps.run(*search, "hydra.sweep.dir=whole") == 0
    assert table(tmp_path / "killed") == table(tmp_path / "whole")


@pytest.mark.slow
def test_two_sweeps_in_one_folder_then_ctrl_c(sweeps: Sweeps, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "swept"
    arguments = ("value=1,2", "seconds=60", "hydra.sweep.dir=swept")
    first = sweeps.start(*arguments)
    while first.poll() is None and not (folder / "0/status.json").is_file():
        time.sleep(0.01)
    assert sweeps.here(monkeypatch, *arguments) == 2
    first.send_signal(signal.SIGINT)
    pressed = time.monotonic()
    assert first.wait(timeout=60) == 130
    assert time.monotonic() - pressed < PROMPT
    assert sweeps.told().strip() == "dr-lab: interrupted."
    assert [row["status"] for row in table(folder)] == ["unfinished", "waiting"]


@pytest.mark.slow
def test_full_disk(sweeps: Sweeps, tmp_path: Path) -> None:
    arguments = ("value=1", "size=10000", "hydra.sweep.dir=swept")
    assert sweeps.run("value=1,2,3,4,5,6", *arguments[1:], PROBE_FILE_LIMIT="500") == 2  # too few for the list of jobs
    assert "sweep.json: File too large" in sweeps.told()
    assert not list((tmp_path / "swept").glob("*/"))
    assert sweeps.run(*arguments, PROBE_FILE_LIMIT="9000") == 2
    assert "1 failed, of 1 in all." in sweeps.told()
    assert "filling.txt: File too large" in sweeps.told()
    assert sweeps.run(*arguments) == 0
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed"]


@pytest.mark.slow
def test_worker_that_dies_takes_no_other_job_with_it(sweeps: Sweeps, tmp_path: Path) -> None:
    """joblib loses what waits for a broken pool; those jobs are handed over again."""
    arguments = ("value=1,2,3,4", "hydra/launcher=cores", "hydra.launcher.n_jobs=2", "hydra.sweep.dir=swept")
    (sweeps.trouble / "dies_2").touch()
    assert sweeps.run(*arguments) == 2
    states = [row["status"] for row in table(tmp_path / "swept")]
    assert states[1] == "unfinished"
    assert "waiting" not in states
    (sweeps.trouble / "dies_2").unlink()
    assert sweeps.run(*arguments) == 0
    assert [row["status"] for row in table(tmp_path / "swept")] == ["completed"] * 4


@pytest.mark.slow
def test_worker_that_outlives_its_killed_driver(sweeps: Sweeps, tmp_path: Path) -> None:
    arguments = ("value=1,2", "seconds=8", "hydra/launcher=cores", "hydra.launcher.n_jobs=2")
    kill_and_complete(sweeps, tmp_path / "swept", [1.0], *arguments)
    reports = [json.loads((tmp_path / f"swept/{n}/report.json").read_text(encoding="utf-8")) for n in range(2)]
    assert [report["score"] for report in reports] == [4.0, 1.0]
