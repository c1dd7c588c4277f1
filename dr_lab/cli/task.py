"""What Hydra calls for every job: a command's only one, or one of a sweep's, in whatever process it runs."""

from pathlib import Path

from hydra.conf import HydraConf
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from dr_lab.cli.arguments import checked
from dr_lab.cli.compose import require_no_search
from dr_lab.cli.explain import explain
from dr_lab.cli.job import Job, discard, run_job
from dr_lab.cli.sweep_job import run_in_sweep
from dr_lab.errors import ConfigError
from dr_lab.stopping import stop_if_asked


class Task:
    """A verb as Hydra's task function; it travels to the processes that run a sweep's jobs.

    Args:
        verb: name of a root configuration.
        folders: configuration folders, first searched first; the last one ships with dr_lab.
        traceback_wanted: a sweep's errors are raised as they are.

    Attributes:
        failures: what a single job raised, because Hydra would announce it in words of its own.
    """

    def __init__(self, verb: str, folders: tuple[Path, ...], traceback_wanted: bool) -> None:
        self.verb, self.folders, self.traceback_wanted = verb, folders, traceback_wanted
        self.failures: list[Exception] = []
        # Hydra names the job after the module of its function.
        self.__module__ = f"dr_lab.workflows.{verb}"

    def __call__(self, cfg: DictConfig) -> None:
        """Run one job.

        Args:
            cfg: its composed configuration without Hydra's node.

        Raises:
            DrLabError: a job of a sweep failed.
        """
        stop_if_asked()
        state = HydraConfig.get()
        overrides = tuple(map(str, OmegaConf.to_container(state.overrides.task, resolve=False) or ()))
        output_dir = Path(state.runtime.output_dir)
        job = Job(self.verb, overrides, state.runtime.choices.get("base"), output_dir, self.folders)
        if state.mode == RunMode.MULTIRUN:
            run_in_sweep(job, cfg, state, self.traceback_wanted)
            return
        try:
            _require_no_search(job, cfg, state)
            run_job(job, cfg)
        except Exception as error:
            self.failures.append(error)

    def fault(self, cfg: DictConfig) -> str | None:
        """What is wrong with a job's configuration, or None; nothing is built.

        Args:
            cfg: its composed configuration without Hydra's node.
        """
        try:
            checked(self.verb, cfg, self.folders)
        except Exception as error:
            if self.traceback_wanted:
                raise
            return explain(error, self.verb, self.folders)[0]
        return None


def _require_no_search(job: Job, cfg: DictConfig, hydra: HydraConf) -> None:
    """Refuse to run one job of a configuration that asks for many; its folder goes."""
    try:
        require_no_search(hydra.sweeper, job.verb, job.overrides)
    except ConfigError:
        discard(job.output_dir, cfg)
        raise
