"""Hydra launcher whose jobs are tasks of Ray, on this machine or on a cluster."""

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from hydra.core.hydra_config import HydraConfig
from hydra.core.singleton import Singleton
from hydra.core.utils import JobReturn, JobStatus, filter_overrides, run_job, setup_globals
from hydra.plugins.launcher import Launcher
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, open_dict

from dr_lab.bounds import NotNegative, Positive, require_bounds
from dr_lab.errors import ConfigError
from dr_lab.extras import MissingLibraryError
from dr_lab.ray_cluster import own_sigterm, prepare, unanswered


class RayLauncher(Launcher):
    """One Ray task per job of a sweep.

    A job that raises, dies or loses its machine fails once and alone: Ray never starts it again, the others go on, and
    results come back in the order of the jobs. Jobs run in the folder where the command was typed, so its path and the
    sweep's must exist on every machine. Ctrl-C or SIGTERM interrupts the running jobs, then kills those that
    do not end.

    Args:
        init: arguments of `ray.init`. ``address``: of a running cluster; ``local`` starts Ray for this sweep alone.
        job: what each job reserves, arguments of `ray.remote`: ``num_cpus``, ``num_gpus``, ``memory`` [B],
            ``resources``, ``runtime_env``.
        grace: time that interrupted jobs have to put their files in order [s].
        patience: time that a running cluster has to answer [s].
    """

    def __init__(self, init: Mapping[str, Any], job: Mapping[str, Any], grace: NotNegative, patience: Positive) -> None:
        self.init, self.job, self.grace, self.patience = init, job, grace, patience
        require_bounds(self, "hydra.launcher", RayLauncher)
        self.sweep: tuple[HydraContext, TaskFunction, DictConfig] | None = None

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """Take what Hydra gives before it launches."""
        self.sweep = (hydra_context, task_function, config)

    def launch(self, job_overrides: Sequence[Sequence[str]], initial_job_idx: int) -> Sequence[JobReturn]:
        """Run jobs and wait for all of them.

        Args:
            job_overrides: of each job.
            initial_job_idx: number of the first.

        Returns:
            What each job returned or raised, in the order of `job_overrides`.

        Raises:
            ConfigError: Ray is not installed, no cluster answers, or no machine is large enough for a job.
        """
        assert self.sweep is not None
        setup_globals()
        folder = Path(str(self.sweep[2].hydra.sweep.dir)).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        with _cluster(self.init, self.patience) as ray:
            _require_room(ray.nodes(), self.job)
            task = ray.remote(max_retries=0, **self.job)(run)
            shared = ray.put((*self.sweep, Singleton.get_state(), str(folder), os.getcwd()))
            jobs = {
                task.options(name=_told(overrides)).remote(shared, list(overrides), number): overrides
                for number, overrides in enumerate(job_overrides, initial_job_idx)
            }
            return self._wait(ray, jobs)

    def _wait(self, ray: ModuleType, jobs: Mapping[object, Sequence[str]]) -> list[JobReturn]:
        """Gather the jobs as they end, with one line for each; stop them all if this is interrupted."""
        begun, running = time.monotonic(), list(jobs)
        results: dict[object, JobReturn] = {}
        try:
            while running:
                (done,), running = ray.wait(running)
                results[done] = _result(ray, done, jobs[done])
                status = results[done].status.name.lower()
                elapsed = f"{time.monotonic() - begun:.0f} s"
                print(f"{len(results)} of {len(jobs)} jobs, {elapsed}: {_told(jobs[done])} {status}", flush=True)
        except BaseException:
            for job in running:
                ray.cancel(job)
            _, stubborn = ray.wait(running, num_returns=len(running), timeout=self.grace)
            for job in stubborn:
                ray.cancel(job, force=True)
            raise
        return [results[job] for job in jobs]


def run(shared: tuple[Any, ...], overrides: list[str], number: int) -> JobReturn:
    """One job, at the machine that Ray chose.

    Args:
        shared: what the jobs have in common.
        overrides: of this job.
        number: of this job in the sweep.
    """
    context, function, config, singletons, sweep_dir, cwd = shared
    os.chdir(cwd)
    setup_globals()
    Singleton.set_state(singletons)
    composed = context.config_loader.load_sweep_config(config, overrides)
    with open_dict(composed):
        composed.hydra.job.id = f"{composed.hydra.job.name}_{number}"
        composed.hydra.job.num = number
        composed.hydra.sweep.dir = sweep_dir
    HydraConfig.instance().set_config(composed)
    return run_job(function, composed, "hydra.sweep.dir", "hydra.sweep.subdir", context)


def _require_room(machines: Sequence[Mapping[str, Any]], job: Mapping[str, Any]) -> None:
    """Refuse jobs that no machine can hold; Ray would wait for one to join, without a word."""
    wanted = {"CPU": job.get("num_cpus"), "GPU": job.get("num_gpus"), "memory": job.get("memory")}
    wanted = {name: amount for name, amount in (wanted | job.get("resources", {})).items() if amount}
    offered = [machine["Resources"] for machine in machines if machine["Alive"]]
    if not any(all(each.get(name, 0) >= amount for name, amount in wanted.items()) for each in offered):
        told = "; ".join(str({name: each.get(name, 0) for name in wanted}) for each in offered)
        raise ConfigError(
            f"hydra.launcher.job asks for {wanted}, which no machine of the Ray cluster offers: {told}. "
            "Ask for less, or start one that does: ray start --num-cpus=… --resources=…"
        )


def _result(ray: ModuleType, job: object, overrides: Sequence[str]) -> JobReturn:
    """What a job returned; where it died, a failure that says how."""
    try:
        return ray.get(job)
    except ray.exceptions.RayError as error:
        failed = JobReturn(overrides=list(overrides), status=JobStatus.FAILED)
        failed.return_value = error
        return failed


@contextmanager
def _cluster(init: Mapping[str, Any], patience: float) -> Iterator[ModuleType]:
    """Ray, connected."""
    if find_spec("ray") is None:
        raise MissingLibraryError("hydra/launcher=ray", "ray", ", on every machine.")
    prepare("hydra.launcher.init.address", init["address"], patience)
    ray = import_module("ray")  # takes a second, and Hydra imports every plugin at every start
    try:
        with own_sigterm():
            ray.init(**init)
    except (ConnectionError, ray.exceptions.RayError) as error:
        raise unanswered("hydra.launcher.init.address", init["address"], error) from error
    try:
        yield ray
    finally:
        ray.shutdown()


def _told(overrides: Sequence[str]) -> str:
    return " ".join(filter_overrides(overrides))
