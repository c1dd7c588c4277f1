"""What dr_lab's sweepers share: jobs composed and checked before any of them begins, then run by any launcher."""

import copy
import functools
import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, Quote, QuotedString
from hydra.core.utils import JobStatus
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, OmegaConf, open_dict

from dr_lab.bounds import Positive
from dr_lab.cli.arguments import COMMAND_LINE_KEYS
from dr_lab.cli.folders import own_files
from dr_lab.cli.overrides import composed
from dr_lab.cli.task import Task
from dr_lab.errors import ConfigError, DrLabError
from dr_lab.sweeps.job_folder import Status
from dr_lab.sweeps.sweep import SweepJob, identity_of, stop
from dr_lab.sweeps.table import kept_up_to_date, statuses


@dataclass(frozen=True)
class Composed:
    """A job before it has a number.

    Attributes:
        overrides: that make its configuration.
        cfg: its configuration with Hydra's node.
        identity: `identity_of` its configuration without it and without what says where results go, and of the files
            of the user's own that it names.
    """

    overrides: tuple[str, ...]
    cfg: DictConfig
    identity: str

    def numbered(self, number: int) -> SweepJob:
        """The job under a number, which its folder may follow."""
        with open_dict(self.cfg.hydra.job):
            self.cfg.hydra.job.num = self.cfg.hydra.job.id = number
        return SweepJob(number, self.identity, str(self.cfg.hydra.sweep.subdir), self.overrides)


class DrLabSweeper(BasicSweeper):
    """A sweep that the same command continues.

    Args:
        params: sweeps that a configuration asks for, beside those on the command line: key → values.
        fail_fast: let no further job begin once one has failed.
        refresh: time between two looks at the jobs for ``sweep.csv`` [s].
        columns: figures of the jobs' reports that it shows.

    Attributes:
        option: of ``hydra/sweeper``, which a sweep's folder keeps.
    """

    option: ClassVar[str]

    def __init__(
        self, params: Mapping[str, Any] | None, fail_fast: bool, refresh: Positive, columns: Sequence[str] = ()
    ) -> None:
        super().__init__(max_batch_size=None, params=dict(params or {}))
        self.fail_fast, self.refresh, self.columns = fail_fast, refresh, columns
        self.task: Task | None = None
        self.shown = self.folder = Path()

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        """Take what Hydra gives, and settle the sweep's folder for every job, wherever it will run.

        Raises:
            ConfigError: the sweep is given no folder.
        """
        assert isinstance(task_function, Task)
        if not config.hydra.sweep.dir:
            raise ConfigError("hydra.sweep.dir is empty; expected the folder of the sweep, e.g. hydra.sweep.dir=sweep.")
        self.task = task_function
        self.shown = Path(str(config.hydra.sweep.dir))
        # Behind a link, ".." is another folder than Hydra makes of it.
        self.folder = self.shown.resolve() if ".." in self.shown.parts else self.shown.absolute()
        config.hydra.sweep.dir = str(self.folder)
        config.hydra.overrides.hydra.append(f"hydra.sweep.dir={_quoted(str(self.folder))}")
        super().setup(hydra_context=hydra_context, task_function=task_function, config=config)

    @abstractmethod
    def sweep(self, arguments: list[str]) -> None:
        """Run the jobs that the command line asks for."""

    def parsed(self, arguments: Sequence[str]) -> list[Override]:
        """The overrides of the command line and of the configuration.

        Args:
            arguments: as typed, those of Hydra's own node apart.
        """
        assert self.hydra_context is not None
        parser = OverridesParser.create(config_loader=self.hydra_context.config_loader)
        return parser.parse_overrides([*self._parse_config(), *arguments])

    def composed(self, overrides: Sequence[str]) -> Composed:
        """Compose a job.

        Args:
            overrides: of it.

        Raises:
            hydra.errors.HydraException: an override names nothing.
        """
        assert self.hydra_context is not None
        assert self.config is not None
        load = functools.partial(self.hydra_context.config_loader.load_sweep_config, self.config)
        spelt, cfg = composed(overrides, load)
        values = OmegaConf.to_container(_without_hydra(cfg), resolve=False)
        assert isinstance(values, dict)
        kept = {str(key): value for key, value in values.items() if key not in COMMAND_LINE_KEYS}
        assert self.task is not None
        # The same names may stand for other files: another --config-dir, or another content.
        own = own_files(kept, self.task.folders[:-1])
        return Composed(tuple(spelt), cfg, identity_of(kept | own))

    def check(self, jobs: Sequence[Composed]) -> None:
        """Check the configurations of all jobs.

        Args:
            jobs: composed ones.

        Raises:
            ConfigError: some cannot be run; says so of each fault once.
        """
        assert self.task is not None
        faulty: dict[str, Composed] = {}
        count = 0
        for job in jobs:
            fault = self.task.fault(_without_hydra(job.cfg))
            if fault is not None:
                count += 1
                faulty.setdefault(fault, job)
        if faulty:
            lines = [f"  {' '.join(job.overrides)}: {fault}" for fault, job in faulty.items()]
            what = f"{count} of {len(jobs)} jobs cannot be run, so none was begun:"
            raise ConfigError("\n".join([what, *lines]))

    def launch(self, jobs: Sequence[SweepJob]) -> tuple[dict[int, Status], str]:
        """Run jobs with the launcher, whatever it makes of one that raises or dies; those that died before come last.

        Args:
            jobs: of this sweep, written down in its folder.

        Returns:
            How they stand then, with what the launcher alone knows of a failure, and why it gave up, if it did.

        Raises:
            DrLabError: the launcher cannot be used, or the table cannot be written.
        """
        before = statuses(self.folder, jobs)
        left, ended_early = sorted(jobs, key=lambda job: before[job.number].state == "unfinished"), ""
        unrecorded: dict[int, Status] = {}
        with kept_up_to_date(self.folder, self.refresh, self.columns):
            try:
                while left:
                    left, ended_early = self._launch_once(left, unrecorded)
                # An engine may give up at the first job that died, while others go on.
                while "running" in {status.state for status in statuses(self.folder, jobs).values()}:
                    time.sleep(self.refresh)
            except BaseException:
                stop(self.folder, "interrupted")  # jobs that wait in the queue of a cluster are not begun either
                raise
        return statuses(self.folder, jobs) | unrecorded, ended_early

    def _launch_once(self, jobs: Sequence[SweepJob], unrecorded: dict[int, Status]) -> tuple[list[SweepJob], str]:
        """Hand jobs to the launcher; gives those to hand over again, and why it gave up, if it did."""
        assert self.launcher is not None
        before = statuses(self.folder, jobs)
        batch = [[*job.overrides, f"hydra.sweep.subdir={_quoted(job.folder)}"] for job in jobs]
        try:
            returned = self.launcher.launch(batch, initial_job_idx=jobs[0].number)
        except DrLabError:
            raise
        except BrokenProcessPool as error:  # a worker that dies takes with it what waits for its pool
            after = statuses(self.folder, jobs)
            untouched = [job for job in jobs if after[job.number] == before[job.number]]
            return untouched if len(untouched) < len(jobs) else [], _told(error)
        except Exception as error:  # each launcher has errors of its own for a job that died
            return [], _told(error)
        after = statuses(self.folder, jobs)
        for job, what in zip(jobs, returned, strict=True):
            if what.status == JobStatus.FAILED and after[job.number] == before[job.number]:
                unrecorded[job.number] = Status("unrecorded", _told(what._return_value))
        return [], ""


def _told(error: Exception) -> str:
    return str(error) if isinstance(error, DrLabError) else f"{type(error).__name__}: {error}"


def _without_hydra(cfg: DictConfig) -> DictConfig:
    job = copy.deepcopy(cfg)
    with open_dict(job):
        del job["hydra"]
    return job


def _quoted(text: str) -> str:
    return QuotedString(text, Quote.single).with_quotes()
