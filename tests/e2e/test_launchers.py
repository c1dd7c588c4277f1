"""The sweeps of launchers/README.md, by its very commands, on every launcher; daemons are started for them."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from ray_cluster import Machine
from slurm_cluster import free_ports, missing, one_node_slurm

from dr_lab.cli.folders import PACKAGE

README = (PACKAGE.parent / "launchers/README.md").read_text(encoding="utf-8")
PROGRAMS = Path(sys.executable).parent
JOBS = 12
PATIENCE = 500.0  # s for a sweep; 30 to 90 on two busy cores
ENVIRONMENT = os.environ | {"PATH": f"{PROGRAMS}{os.pathsep}{os.environ['PATH']}", "OMP_NUM_THREADS": "1"}


def command(*words: str) -> str:
    """The one command of the README that has all these words."""
    blocks = "".join(README.split("```")[1::2])
    [found] = [line for line in blocks.splitlines() if all(word in line for word in words)]
    return found


def run(line: str, folder: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """Type a line in a folder."""
    return subprocess.run(
        ["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
    )


def jobs(folder: Path) -> dict[str, str]:
    """How the jobs of the sweep in a folder stand, by number."""
    tables = list(folder.glob("outputs/multirun/record/*/sweep.csv"))
    if not tables:
        return {}
    [table] = tables
    with table.open(encoding="utf-8") as file:
        return {row["number"]: row["status"] for row in csv.DictReader(file)}


def completed(folder: Path) -> dict[Path, int]:
    """The completed jobs' logs, each with when it was written."""
    done = [number for number, state in jobs(folder).items() if state == "completed"]
    logs = [path for number in done for path in folder.glob(f"outputs/multirun/record/*/{number}/log_1.mcap")]
    return {log: log.stat().st_mtime_ns for log in logs}


def wait(until: Callable[[], bool]) -> None:
    begun = time.monotonic()
    while not until():
        assert time.monotonic() - begun < PATIENCE
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("launcher", ["basic", "cores", "processes"])
def test_on_this_machine(launcher: str, tmp_path: Path) -> None:
    done = run(command("dr-lab", f"hydra/launcher={launcher} "), tmp_path, ENVIRONMENT)
    assert done.returncode == 0, done.stderr
    assert len(completed(tmp_path)) == JOBS


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    remedy = missing()
    if remedy:
        pytest.skip(remedy)
    with one_node_slurm(tmp_path_factory.mktemp("slurm")) as environment:
        yield ENVIRONMENT | environment | {"PATH": f"{PROGRAMS}{os.pathsep}{environment['PATH']}"}


@pytest.mark.daemons
def test_on_slurm(slurm: dict[str, str], tmp_path: Path) -> None:
    done = run(command("dr-lab", "hydra/launcher=slurm"), tmp_path, slurm)
    assert done.returncode == 0, done.stderr
    assert len(completed(tmp_path)) == JOBS


@pytest.mark.daemons
def test_slurm_jobs_outlive_ctrl_c_and_are_cancelled(slurm: dict[str, str], tmp_path: Path) -> None:
    line = command("dr-lab", "hydra/launcher=slurm").replace("duration=1", "duration=1000")
    driver = subprocess.Popen(["bash", "-c", f"exec {line}"], cwd=tmp_path, env=slurm, stderr=subprocess.PIPE)
    wait(lambda: "running" in jobs(tmp_path).values())
    driver.send_signal(signal.SIGINT)
    driver.communicate(timeout=PATIENCE)
    assert driver.returncode == 130
    assert run("squeue --noheader --states=running", tmp_path, slurm).stdout
    [sweep] = tmp_path.glob("outputs/multirun/record/*")
    assert run(command("scancel"), sweep, slurm).returncode == 0
    wait(lambda: not run("squeue --noheader", tmp_path, slurm).stdout)
    assert completed(tmp_path) == {}


@pytest.fixture
def ray(tmp_path: Path) -> Iterator[tuple[dict[str, str], list[Machine]]]:
    """Environment of a cluster of two machines, and these."""
    [port] = free_ports(1)
    environment = ENVIRONMENT | {
        "HEAD": "127.0.0.1",
        "PORT": str(port),
        "CORES": "1",
        "RAY_AUTH_MODE": "token",
        "RAY_AUTH_TOKEN_PATH": str(tmp_path / "token"),
        "RAY_raylet_start_wait_time_s": "60",  # a busy machine
    }
    run(command("umask"), tmp_path, environment)
    machines: list[Machine] = []
    try:
        for role in ("--head", "--address"):
            machines.append(Machine(command("ray start", role), environment, tmp_path / f"ray{role}.out"))
        yield environment, machines
    finally:
        for machine in reversed(machines):
            machine.leave()


@pytest.mark.daemons
def test_on_ray_whose_second_machine_dies(ray: tuple[dict[str, str], list[Machine]], tmp_path: Path) -> None:
    environment, (_, second) = ray
    line = command("dr-lab", "hydra/launcher=ray")
    driver = subprocess.Popen(["bash", "-c", f"exec {line}"], cwd=tmp_path, env=environment, stderr=subprocess.PIPE)
    wait(lambda: len(completed(tmp_path)) >= 3)
    second.die()
    _, told = driver.communicate(timeout=PATIENCE)
    kept = completed(tmp_path)
    assert len(kept) >= JOBS - 1, told
    assert driver.returncode == (0 if len(kept) == JOBS else 2)
    again = run(line, tmp_path, environment)
    assert again.returncode == 0, again.stderr
    assert len(completed(tmp_path)) == JOBS
    assert completed(tmp_path).items() >= kept.items()
    stranger = environment | {"RAY_AUTH_TOKEN_PATH": os.devnull}
    refused = run(line.replace("range(12)", "range(13)"), tmp_path, stranger)
    assert refused.returncode == 2
    assert "No Ray cluster at hydra.launcher.init.address=127.0.0.1" in refused.stderr
