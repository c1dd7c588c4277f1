"""A sweep as one table, ``sweep.csv``: a row a job, the overrides that differ as columns."""

import csv
import io
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from dr_lab.errors import DrLabError
from dr_lab.files import write_text
from dr_lab.sweeps.job_folder import ERROR_FILE, FINAL, Status, read_status
from dr_lab.sweeps.objective import objectives
from dr_lab.sweeps.overrides import by_key, differing
from dr_lab.sweeps.sweep import SweepJob, read_jobs

TABLE_FILE = "sweep.csv"


def statuses(sweep_dir: Path, jobs: Sequence[SweepJob]) -> dict[int, Status]:
    """How jobs stand, by number.

    Args:
        sweep_dir: folder of the sweep.
        jobs: of it.
    """
    return {job.number: read_status(sweep_dir / job.folder) for job in jobs}


def log_of(sweep_dir: Path, job: SweepJob) -> Path:
    """Where to read more about a job: its error with the traceback, or else its folder.

    Args:
        sweep_dir: folder of the sweep.
        job: of it.
    """
    folder = sweep_dir / job.folder
    return folder / ERROR_FILE if (folder / ERROR_FILE).is_file() else folder


def write_table(
    sweep_dir: Path, jobs: Sequence[SweepJob], standing: Mapping[int, Status], figures: Sequence[str] = ()
) -> None:
    """Write ``sweep.csv``.

    Columns: number, folder, status, the overrides that differ, figures, seconds, the error's first line, and its log.
    Paths are relative to the sweep's folder.

    Args:
        sweep_dir: folder of the sweep.
        jobs: of it, in order of their numbers.
        standing: how they stand, by number.
        figures: keys of the reports of completed jobs.

    Raises:
        DrLabError: the file cannot be written.
    """
    typed = {job.number: by_key(job.overrides) for job in jobs}
    keys = differing(list(typed.values()))
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["number", "folder", "status", *keys, *figures, "seconds", "error", "log"])
    for job in jobs:
        status = standing[job.number]
        overrides = [typed[job.number].get(key, "") for key in keys]
        log = log_of(sweep_dir, job).relative_to(sweep_dir) if status.state == "failed" else ""
        reached = _reached(sweep_dir / job.folder, status, figures)
        seconds = "" if status.seconds is None else f"{status.seconds:.3f}"
        row = [job.number, job.folder, status.state, *overrides, *reached, seconds, first_line(status.error), log]
        rows.writerow(row)
    write_text(sweep_dir / TABLE_FILE, text.getvalue())


def _reached(folder: Path, status: Status, figures: Sequence[str]) -> Sequence[float | str]:
    """Figures of a job, empty ones where it has none."""
    if status.state != "completed":
        return [""] * len(figures)
    try:
        return objectives(folder, figures) if figures else ()
    except DrLabError:  # who needs the figures says what is wrong with them
        return [""] * len(figures)


def first_line(text: str) -> str:
    """The first line of a text, or nothing."""
    return next(iter(text.splitlines()), "")


@contextmanager
def kept_up_to_date(sweep_dir: Path, every: float, figures: Sequence[str] = ()) -> Iterator[None]:
    """Keep ``sweep.csv`` true while jobs run, here or elsewhere, and once more at the end.

    Args:
        sweep_dir: folder of the sweep.
        every: s between two looks.
        figures: keys of the reports of completed jobs.

    Raises:
        DrLabError: the last table cannot be written.
    """
    jobs = read_jobs(sweep_dir)
    standing = statuses(sweep_dir, jobs)
    write_table(sweep_dir, jobs, standing, figures)
    ended = threading.Event()

    def look() -> None:
        while not ended.wait(every):
            open_jobs = [job for job in jobs if standing[job.number].state not in FINAL]
            now = standing | statuses(sweep_dir, open_jobs)
            if now != standing:
                try:
                    write_table(sweep_dir, jobs, now, figures)
                except DrLabError:  # a full disk may have room again at the next look; the last table must be written
                    continue
                standing.update(now)

    looking = threading.Thread(target=look, name="sweep.csv", daemon=True)
    looking.start()
    try:
        yield
    finally:
        ended.set()
        looking.join()
        write_table(sweep_dir, jobs, statuses(sweep_dir, jobs), figures)
