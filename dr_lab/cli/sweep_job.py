"""One job of a sweep: taken up where it stands, and how it ended written into its folder."""

import sys
import time
import traceback
from dataclasses import replace
from pathlib import Path

from hydra.conf import HydraConf
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.explain import explain
from dr_lab.cli.job import Job, can_go_on, run_job
from dr_lab.cli.pruning import watched
from dr_lab.errors import DrLabError
from dr_lab.files import remove_leftovers, write_text
from dr_lab.run_command import CONFIG_FILE
from dr_lab.stopping import stop_if_asked
from dr_lab.sweeps.job_folder import ERROR_FILE, FINAL, clear, held, read_status, write_status
from dr_lab.sweeps.progress import Pruned
from dr_lab.sweeps.sweep import is_stopped, read_jobs, stop


def run_in_sweep(job: Job, cfg: DictConfig, hydra: HydraConf, traceback_wanted: bool) -> None:
    """Run a job of a sweep, unless it is completed already or the sweep was stopped.

    A job that died is gone on with in its folder where its verb can do so, else it starts over in an empty one. Where a
    process that outlived its sweep still works on it, that process is waited for.

    Args:
        job: which one.
        cfg: its composed configuration without Hydra's node.
        hydra: Hydra's node.
        traceback_wanted: errors are raised as they are.

    Raises:
        DrLabError: the job failed; Hydra then goes on with the others.
    """
    sweep_dir = Path(hydra.sweep.dir)
    number = next((e.number for e in read_jobs(sweep_dir) if sweep_dir / e.folder == job.output_dir), None)
    if number is None:
        raise DrLabError(f"{job.output_dir} is no folder of a sweep of dr_lab's. Sweep with hydra/sweeper=resume.")
    with held(job.output_dir):
        if read_status(job.output_dir).state in FINAL or is_stopped(sweep_dir):
            return
        label = f"job {number} ({' '.join(job.overrides)})"
        print(f"\n{label}")
        with watched(hydra, number):
            error = _attempt(job, cfg)
    if error is None:
        return
    if OmegaConf.select(hydra.sweeper, "fail_fast", default=False):
        stop(sweep_dir, f"{label} failed")
    if traceback_wanted:
        raise error
    message = f"{label} failed: {explain(error, job.verb, job.folders)[0]}"
    print(message, file=sys.stderr)
    raise DrLabError(message) from None


def _attempt(job: Job, cfg: DictConfig) -> Exception | None:
    """Do a job's work and write down how it ended; gives what made it fail."""
    folder = job.output_dir
    begin = time.monotonic()
    try:
        run_job(_taken_up(job), cfg)
    except Pruned:
        write_status(folder, "pruned", seconds=time.monotonic() - begin)
    except Exception as error:
        stop_if_asked()
        message = explain(error, job.verb, job.folders)[0]
        write_text(folder / ERROR_FILE, f"{message}\n\n{''.join(traceback.format_exception(error))}")
        write_status(folder, "failed", message, time.monotonic() - begin)
        return error
    else:
        write_status(folder, "completed", seconds=time.monotonic() - begin)
    return None


def _taken_up(job: Job) -> Job:
    """The job, going on where it was if it can; its folder is put in order for that."""
    folder = job.output_dir
    if can_go_on(job):
        job = replace(job, resume=folder)
        for name in (CONFIG_FILE, ERROR_FILE):  # written anew
            (folder / name).unlink(missing_ok=True)
        remove_leftovers(folder)
    else:
        clear(folder)
    write_status(folder, "running")
    return job
