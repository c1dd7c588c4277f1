"""What the user is told when a sweep's command ends."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from dr_lab.errors import DrLabError
from dr_lab.sweeps.job_folder import FINAL, Status
from dr_lab.sweeps.sweep import SweepJob
from dr_lab.sweeps.table import TABLE_FILE, first_line, log_of

_DIED = "its process ended without a word: killed, out of memory or out of its time limit"


class SweepError(DrLabError):
    """Jobs of a sweep failed, or were not run to their end; the others are kept."""


def require_completed(
    sweep_dir: Path, jobs: Sequence[SweepJob], standing: Mapping[int, Status], ended_early: str = ""
) -> None:
    """Tell of every job that is not completed.

    Args:
        sweep_dir: folder of the sweep.
        jobs: those that the command was about.
        standing: how they stand, by number.
        ended_early: why the engine that runs them gave up, if it did.

    Raises:
        SweepError: there are such jobs.
    """
    states = [standing[job.number].state for job in jobs]
    if all(state in FINAL for state in states):
        return
    counts = {
        "failed": states.count("failed") + states.count("unrecorded"),
        "died": states.count("unfinished"),
        "running elsewhere": states.count("running"),
        "not begun": states.count("waiting"),
    }
    told = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    lines = [f"Not completed: {told}, of {len(jobs)} in all.", *listed(sweep_dir, jobs, standing)]
    if ended_early:
        lines.append(f"What runs the jobs gave up: {first_line(ended_early)}")
    lines.append(f"Table: {sweep_dir / TABLE_FILE}. The same command goes on with these jobs; the others are kept.")
    raise SweepError("\n".join(lines))


def listed(sweep_dir: Path, jobs: Sequence[SweepJob], standing: Mapping[int, Status]) -> Iterator[str]:
    """Of the jobs that failed or died: which, why, and where to read more.

    Args:
        sweep_dir: folder of the sweep.
        jobs: of it.
        standing: how they stand, by number.
    """
    for job in jobs:
        status = standing[job.number]
        if status.state in ("failed", "unfinished", "unrecorded"):
            why = _DIED if status.state == "unfinished" else first_line(status.error)
            yield f"  job {job.number} ({' '.join(job.overrides)}): {why}"
        if status.state in ("failed", "unfinished"):
            yield f"    {log_of(sweep_dir, job)}"
