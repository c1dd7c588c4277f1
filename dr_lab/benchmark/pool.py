"""Cases side by side, each in a file of its own, so that an interrupted run goes on where it stopped."""

import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import active_children, get_context
from pathlib import Path

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.outcome import Outcome
from dr_lab.errors import DrLabError
from dr_lab.files import write_text
from dr_lab.reports.typed import typed

_PATIENCE = 2.0  # s that processes which are told to end have for putting their files away

Diagnose = Callable[[Case], Outcome]


def finished(folder: Path, cases: Sequence[Case]) -> dict[Case, Outcome]:
    """Outcomes that an earlier run left in a folder; a file that belongs to other settings is not one of them."""
    kept = {}
    for case in cases:
        path = _file(folder, case)
        if path.is_file():
            with suppress(ValueError, KeyError, TypeError):
                outcome = Outcome.from_json(path.read_text(encoding="utf-8"))
                if outcome.case == case:
                    kept[case] = outcome
    return kept


def keep(folder: Path, outcomes: Mapping[Case, Outcome]) -> None:
    """Write outcomes, one file a case."""
    for case, outcome in outcomes.items():
        write_text(_file(folder, case), outcome.to_json())


def run_cases(
    cases: Sequence[Case], diagnose: Diagnose, folder: Path, processes: int
) -> Generator[tuple[Case, Outcome | str]]:
    """Diagnose cases, one thread each, and keep their outcomes as they come.

    Args:
        cases: what to do.
        diagnose: what is called with each, in another process: it must be importable there.
        folder: where the files go.
        processes: cases at a time.

    Yields:
        Each case with its outcome, or with the error that it failed with, in words; a failed case leaves no file.

    Raises:
        DrLabError: a process was killed, most likely for lack of memory.
    """
    with _single_threaded(), _pool(processes) as pool:
        jobs = {pool.submit(_kept, case, diagnose, folder): case for case in cases}
        for job in as_completed(jobs):
            try:
                yield jobs[job], job.result()
            except BrokenProcessPool as error:
                raise DrLabError(
                    "A process of the benchmark was killed, most likely for lack of memory. Finished cases are kept; "
                    f"go on with {typed('resume', folder.parent)} and fewer processes=…"
                ) from error


def _file(folder: Path, case: Case) -> Path:
    return folder / f"{case.name}.json"


def _kept(case: Case, diagnose: Diagnose, folder: Path) -> Outcome | str:
    try:
        outcome = diagnose(case)
    except Exception as error:  # one case that fails must not end the others; as text, for some errors do not travel
        place = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"
    keep(folder, {case: outcome})
    return Outcome.from_json(outcome.to_json())  # as a run that is resumed reads it


@contextmanager
def _pool(processes: int) -> Iterator[ProcessPoolExecutor]:
    """A pool of fresh processes, ended at once where the block is left by an error or Ctrl-C."""
    strangers = set(active_children())
    pool = ProcessPoolExecutor(processes, get_context("spawn"), initializer=_left_to_parent)
    try:
        yield pool
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        own = set(active_children()) - strangers
        for child in own:
            child.terminate()
        deadline = time.monotonic() + _PATIENCE
        for child in own:
            child.join(max(deadline - time.monotonic(), 0.0))
            child.kill()
        raise
    pool.shutdown()


def _left_to_parent() -> None:
    """Ctrl-C is the parent's business; it then ends its children, which put their temporary files away."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Numerical libraries of new processes use one thread each: the cores are taken by cases."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ["OMP_NUM_THREADS"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["OMP_NUM_THREADS"]
        else:
            os.environ["OMP_NUM_THREADS"] = before
