"""Hydra sweeper that the same command continues: completed jobs are kept, the others run again."""

from collections.abc import Sequence

from hydra.core.override_parser.types import Override
from hydra_plugins._dr_lab_sweeper import Composed, DrLabSweeper
from omegaconf import OmegaConf

from dr_lab.errors import ConfigError
from dr_lab.sweeps.job_folder import FINAL
from dr_lab.sweeps.report import require_completed
from dr_lab.sweeps.sweep import SweepJob, add_jobs, only_driver, read_jobs
from dr_lab.sweeps.table import TABLE_FILE, statuses


class ResumeSweeper(DrLabSweeper):
    """Every combination of the given values, one job each.

    A job is known by the hash of its configuration and of the user's own files that this names. It keeps its number
    and its folder, and once completed it is never run again. Values that are given later join under the next numbers.
    """

    option = "resume"

    def sweep(self, arguments: list[str]) -> None:
        """Run the jobs that are not completed yet.

        Args:
            arguments: overrides as typed, those of Hydra's own node apart.

        Raises:
            ConfigError: there is no job, one cannot be run, two write to one `output`, or another command drives the
                sweep.
            SweepError: jobs failed or died; the others are kept.
        """
        given = self.parsed(arguments)
        for override in given:
            _require_values(override)
        [combinations] = self.split_arguments(given, None)
        asked = [self.composed(overrides) for overrides in combinations]
        self.check(asked)
        _require_apart(asked)
        with only_driver(self.folder, self.option):
            jobs = self._enrolled(asked)
            standing = statuses(self.folder, jobs)
            left = [job for job in jobs if standing[job.number].state not in FINAL]
            print(f"Sweep in {self.shown}: {len(left)} to run, {len(jobs) - len(left)} completed before")
            now, ended_early = self.launch(left)
            require_completed(self.shown, jobs, statuses(self.folder, jobs) | now, ended_early)
        print(f"\nCompleted: {self.shown / TABLE_FILE}")
        if not left:
            print("Nothing was left to do. To run them anew, choose another folder: hydra.sweep.dir=…")

    def _enrolled(self, asked: Sequence[Composed]) -> list[SweepJob]:
        """The jobs with their numbers, in order; those that are new to the sweep are written down."""
        known = read_jobs(self.folder)
        by_identity = {job.identity: job for job in known}
        new: list[SweepJob] = []
        for job in asked:
            if job.identity not in by_identity:
                by_identity[job.identity] = job.numbered(len(known) + len(new))
                new.append(by_identity[job.identity])
        if new:
            assert self.task is not None
            add_jobs(self.folder, self.task.verb, self.option, new)
        wanted = dict.fromkeys(job.identity for job in asked)
        return sorted((by_identity[identity] for identity in wanted), key=lambda job: job.number)


def _require_values(override: Override) -> None:
    """Refuse a sweep of which no job can be made."""
    if not override.is_sweep_override():
        return
    if not override.is_discrete_sweep():
        raise ConfigError(
            f"{override.input_line} leaves the value to a search: hydra/sweeper=study or hparams_search=NAME. For one "
            f"job a value list them: {override.get_key_element()}=VALUE,VALUE"
        )
    if not list(override.sweep_iterator()):  # of which null is a value
        raise ConfigError(f"{override.input_line} holds no value, so there is no job.")


def _require_apart(jobs: Sequence[Composed]) -> None:
    """Refuse jobs of which one would write over another's `output`."""
    writers: dict[str, int] = {}
    for job in {job.identity: job for job in jobs}.values():
        folder = OmegaConf.select(job.cfg, "output")
        if folder is not None:
            writers[str(folder)] = writers.get(str(folder), 0) + 1
    shared = next((folder for folder, count in writers.items() if count > 1), None)
    if shared is not None:
        raise ConfigError(
            f"output is {shared!r} in {writers[shared]} jobs, which would write over one another. Let it hold what "
            f"differs, such as 'output={shared}/${{seed}}', or leave it out: each job then writes to its own folder."
        )
