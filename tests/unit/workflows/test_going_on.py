"""What is printed where a run stops or is at its end: the way to go on, in one line that can be typed."""

from collections.abc import Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from pretended_cases import case_of

from dr_lab.benchmark import pool
from dr_lab.benchmark.case import Case
from dr_lab.benchmark.outcome import Outcome
from dr_lab.errors import DrLabError
from dr_lab.reports.typed import typed
from dr_lab.workflows import benchmark, train

RUN = f"{'my_machine_' * 12}/arm [left], again"  # longer than a terminal is wide, with signs of Rich, Hydra and shells


def stopped(*_: object) -> Iterator[Any]:
    raise KeyboardInterrupt
    yield


def undiagnosed(case: Case) -> Outcome:
    raise AssertionError(case.name)


def training(frames: int) -> Any:  # noqa: ANN401 (what stands in for a training)
    """A training that is stopped at once."""
    trainer = SimpleNamespace(frames=frames, run=lambda *_: next(stopped()), resume=lambda _: None, close=lambda: None)
    return SimpleNamespace(trainer=trainer)


def test_a_training_that_is_stopped(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / RUN
    folder.mkdir(parents=True)
    (folder / "checkpoint.pt").touch()
    plan: Any = SimpleNamespace(frames=9)
    unasked: Any = SimpleNamespace()
    with pytest.raises(KeyboardInterrupt):
        train._run(training(3), unasked, unasked, plan, folder)
    assert f"Interrupted. To go on, add {typed('resume', folder)}\n" in capsys.readouterr().out


def test_a_training_that_is_at_its_end(capsys: pytest.CaptureFixture[str]) -> None:
    plan: Any = SimpleNamespace(frames=3)
    train._go_on(training(3), plan, RUN)
    assert capsys.readouterr().out.startswith(f"{RUN} has played 3 control steps, and frames is 3: nothing is left")


def test_a_benchmark_that_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(benchmark, "run_cases", stopped)
    with pytest.raises(KeyboardInterrupt):
        benchmark._run([case_of("none")], undiagnosed, {}, tmp_path / RUN / "cases", 1)
    told = f"0 cases are done and kept. To go on, add {typed('resume', tmp_path / RUN)}\n"
    assert told in capsys.readouterr().out


def test_a_benchmark_whose_process_was_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    job: Future[Outcome] = Future()
    job.set_exception(BrokenProcessPool())
    made = SimpleNamespace(submit=lambda *_: job)
    monkeypatch.setattr(pool, "_pool", lambda _: nullcontext(made))
    with pytest.raises(DrLabError) as killed:
        next(pool.run_cases([case_of("none")], undiagnosed, tmp_path / RUN / "cases", 1))
    assert f"go on with {typed('resume', tmp_path / RUN)} and fewer processes" in str(killed.value)
