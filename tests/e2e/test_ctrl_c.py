"""Ctrl-C and SIGTERM: a prompt end, one line, and nothing half-written, whatever the run was doing."""

import csv
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import yaml
from hydra.utils import instantiate
from mcap.reader import make_reader

from dr_lab.cli.compose import compose
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.search.rank import rank
from dr_lab.effects.catalogue import candidates

PROGRAM = Path(sys.executable).with_name("dr-lab")
CTRL_C = (signal.SIGINT, 130, "interrupted")
SIGTERM = (signal.SIGTERM, 143, "terminated")
PROMPT = 5.0  # s; a fifth of it on a quiet machine
LOGS = ["measurements.fit=[log_1]", "measurements.held_out=[log_5]"]
SMALL = [*LOGS, "windows.seconds=2.4"]
FEW = "effect=[coulomb_friction,viscous_friction,quadratic_drag,spring,constant_offset]"
PRESSES_ITSELF = """
import os, signal, sys
_, moment, part, *sys.argv[1:] = sys.argv
def press(event, arguments):
    if event == moment and os.path.basename(str(arguments[0])).startswith(part):
        os.kill(os.getpid(), signal.SIGINT)
from dr_lab.__main__ import main
sys.addaudithook(press)
sys.exit(main())
"""
READERS: dict[str, Callable[[Path], object]] = {
    ".yaml": lambda path: yaml.safe_load(path.read_text(encoding="utf-8")),
    ".json": lambda path: json.loads(path.read_text(encoding="utf-8")),
    ".csv": lambda path: list(csv.DictReader(path.read_text(encoding="utf-8").splitlines())),
    ".md": lambda path: path.read_text(encoding="utf-8"),
    ".html": lambda path: path.read_text(encoding="utf-8").index("</html>"),
    ".xml": lambda path: path.read_text(encoding="utf-8").index("</mujoco>"),
    ".npz": lambda path: np.load(path)["qpos"],
    ".rrd": lambda path: len(list(rr.chunk.RrdReader(path).stream())),
    ".mcap": lambda path: make_reader(path.open("rb")).get_summary(),
}


def interrupted(
    folder: Path, *arguments: str, when: Callable[[], bool], sent: tuple[signal.Signals, int, str] = CTRL_C
) -> set[str]:
    """Start `dr-lab`, press Ctrl-C when told so; gives the names of the files that are left, all of them whole."""
    process = start([PROGRAM], folder, *arguments)
    while process.poll() is None and not when():
        time.sleep(0.001)
    process.send_signal(sent[0])
    pressed = time.monotonic()
    left = left_by(process, folder, sent)
    assert time.monotonic() - pressed < PROMPT
    return left


def start(program: list[str | Path], folder: Path, *arguments: str) -> subprocess.Popen[str]:
    command = [*program, *arguments, f"hydra.run.dir={folder}"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def left_by(process: subprocess.Popen[str], folder: Path, sent: tuple[signal.Signals, int, str] = CTRL_C) -> set[str]:
    """Wait for a run that a signal ends; gives the names of the files that are left, all of them whole."""
    _, code, told = sent
    out, error = process.communicate(timeout=60)
    assert process.returncode == code, error
    assert error.strip() == f"dr-lab: {told}."
    assert "Run folder" not in out
    left = list(folder.iterdir()) if folder.is_dir() else []
    for path in left:
        READERS[path.suffix](path)
    return {path.name for path in left}


@pytest.mark.slow
@pytest.mark.parametrize("part", ["report", "review"])
@pytest.mark.parametrize("moment", ["open", "os.rename"])
def test_while_a_file_is_written(tmp_path: Path, part: str, moment: str) -> None:
    """The run presses Ctrl-C itself, just as it makes the temporary file and just before that takes its name."""
    folder = tmp_path / "run"
    process = start([sys.executable, "-c", PRESSES_ITSELF, moment, f".{part}."], folder, "compare", *SMALL)
    left = left_by(process, folder)
    assert "config.yaml" in left
    assert "simulated.mcap" not in left
    assert not [name for name in left if name.startswith(".")]


@pytest.mark.slow
def test_while_candidates_are_fitted(tmp_path: Path) -> None:
    folder, started = tmp_path / "run", []

    def fitting() -> bool:
        if (folder / "config.yaml").is_file():
            started.append(time.monotonic())
        return bool(started) and time.monotonic() - started[0] > 2.5

    assert interrupted(folder, "diagnose", *SMALL, when=fitting) == {"config.yaml"}


def test_sigterm_in_the_middle_of_the_work(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    begun = (folder / "config.yaml").is_file  # minutes before anything else is written
    assert interrupted(folder, "diagnose", *LOGS, FEW, when=begun, sent=SIGTERM) == {"config.yaml"}


def test_while_nothing_has_begun(tmp_path: Path) -> None:
    pressed = time.monotonic() + 0.5
    assert interrupted(tmp_path / "run", "compare", *SMALL, when=lambda: time.monotonic() > pressed) <= {"config.yaml"}


@pytest.mark.slow
def test_candidates_stop_at_their_next_simulation() -> None:
    cfg = compose("diagnose", [*SMALL, FEW, "threads=2"])
    study = prepare(instantiate(cfg.comparison, _convert_="all"))
    base, effects = calibrate(study), instantiate(cfg.effects, _convert_="all")
    placed = candidates(study.model, effects, study.scales, study.compiled).placed
    stopped: list[float] = []

    def done(label: str) -> None:
        stopped.append(time.monotonic())
        raise KeyboardInterrupt(label)

    running = threading.active_count()
    with pytest.raises(KeyboardInterrupt):
        rank(study.bench, base, placed, done)
    assert time.monotonic() - stopped[0] < 2.0
    assert len(stopped) <= 2 < len(placed)
    assert threading.active_count() == running
