"""Hydra sweeper that searches: Optuna proposes values, jobs try them, and the same command goes on until enough are."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import yaml
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra_plugins._dr_lab_sweeper import DrLabSweeper

from dr_lab.bounds import Count, Natural, Positive
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.files import write_text
from dr_lab.sweeps.job_folder import FINAL, Status
from dr_lab.sweeps.objective import objectives
from dr_lab.sweeps.report import SweepError, listed, require_completed
from dr_lab.sweeps.sweep import SweepJob, add_jobs, only_driver, read_jobs
from dr_lab.sweeps.table import TABLE_FILE, statuses

if TYPE_CHECKING:
    from optuna.pruners import BasePruner
    from optuna.samplers import BaseSampler

    from dr_lab.sweeps.study import Best, Proposal, SweepStudy

DIRECTIONS = ("minimize", "maximize")
BEST_FILE = "best.yaml"
ENDED = (*FINAL, "failed")  # a trial that failed is not tried again


class StudySweeper(DrLabSweeper):
    """A search for the values that serve best, one job a trial.

    Args:
        params: what may be tried, beside what the command line says: key → values in Hydra's notation.
        objective: what is judged, keys of the ``report.json`` that a job writes.
        directions: ``maximize`` or ``minimize``, for each of them.
        n_trials: trials in all, those of earlier commands, failed and pruned ones included.
        at_once: trials proposed together, for launchers that run jobs side by side.
        seed: of all proposals.
        sampler: makes Optuna's sampler from a seed.
        pruner: Optuna's, which gives up trials that do badly; None lets each run to its end.
        prune_on: figure that a job tells while it runs, by which the pruner judges.
        fail_fast: propose nothing more once a trial has failed.
        refresh: time between two looks at the jobs for ``sweep.csv`` [s].
    """

    option = "study"

    def __init__(
        self,
        params: Mapping[str, Any] | None,
        objective: Sequence[str],
        directions: Sequence[str],
        n_trials: Count,
        at_once: Count,
        seed: Natural,
        sampler: "Callable[..., BaseSampler]",
        pruner: "BasePruner | None",
        prune_on: str | None,
        fail_fast: bool,
        refresh: Positive,
    ) -> None:
        super().__init__(params, fail_fast, refresh, columns=tuple(objective))
        self.objective, self.directions = tuple(objective), tuple(directions)
        self.n_trials, self.at_once, self.seed, self.sampler = n_trials, at_once, seed, sampler
        if not self.objective or len(self.objective) != len(self.directions):
            given = f"{len(self.objective)} in objective, {len(self.directions)} in directions"
            raise ConfigError(f"A study needs a direction for each objective; got {given} (hydra.sweeper).")
        for direction in set(self.directions) - set(DIRECTIONS):
            raise UnknownNameError("direction", direction, DIRECTIONS, "hydra.sweeper.directions")
        if pruner is not None and (len(self.objective) > 1 or prune_on is None):
            raise ConfigError("hydra.sweeper.pruner needs a single objective, and prune_on, the figure it judges by.")

    def sweep(self, arguments: list[str]) -> None:
        """Try values until there are `n_trials` trials.

        Args:
            arguments: overrides as typed, those of Hydra's own node apart.

        Raises:
            ConfigError: no trial could be run, or the folder holds another study, or another command drives it.
            SweepError: trials died, or none was completed with a finite objective.
        """
        from hydra_plugins._dr_lab_search_space import corners, search_space  # noqa: PLC0415  likewise

        from dr_lab.sweeps.study import SweepStudy  # noqa: PLC0415  Optuna takes half a second, which every command would pay

        given = list({override.get_key_element(): override for override in self.parsed(arguments)}.values())
        [[fixed]] = self.split_arguments([override for override in given if not override.is_sweep_override()], None)
        space = search_space(given)
        self.check([self.composed([*fixed, *_overrides(corner)]) for corner in corners(space)])
        with only_driver(self.folder, self.option):
            study = SweepStudy(self.folder, self.objective, self.directions, space, self.sampler, self.seed)
            print(f"Study in {self.shown}: {self.n_trials} trials in all, {len(study)} begun before")
            self._search(study, fixed)

    def _search(self, study: "SweepStudy", fixed: Sequence[str]) -> None:
        ended_early = ""
        tried: dict[int, SweepJob] = {}
        unrecorded: dict[int, Status] = {}
        failed = False
        while not (failed and self.fail_fast):
            batch = [self._job(proposal, fixed) for proposal in self._proposals(study, tried)]
            if not batch:
                break
            tried |= {job.number: job for job in batch}
            standing = statuses(self.folder, batch)
            now, ended_early = self.launch([job for job in batch if standing[job.number].state not in ENDED])
            standing |= now
            for job in batch:
                self._settle(study, job, standing[job.number])
            unrecorded |= {number: status for number, status in now.items() if status.state == "unrecorded"}
            failed = any(standing[job.number].state in ("failed", "unrecorded") for job in batch)
        self._conclude(study, unrecorded, ended_early)
        if failed and self.fail_fast:
            raise SweepError(f"A trial failed, so the study ends with {len(study)} of {self.n_trials} for now.")

    def _proposals(self, study: "SweepStudy", tried: Mapping[int, SweepJob]) -> "Iterator[Proposal]":
        """The next trials: first those that were begun and whose outcome is not known."""
        begun = [proposal for proposal in study.unfinished() if proposal.number not in tried][: self.at_once]
        yield from begun
        wanted = 0 if study.exhausted else min(self.at_once - len(begun), self.n_trials - len(study))
        for _ in range(wanted):
            yield study.propose()

    def _job(self, proposal: "Proposal", fixed: Sequence[str]) -> SweepJob:
        """The job of a trial, written down where it is new; one that was begun must be what the command asks for."""
        job = self.composed([*fixed, *_overrides(proposal.values)]).numbered(proposal.number)
        known = next((known for known in read_jobs(self.folder) if known.number == job.number), None)
        if known is None:
            assert self.task is not None
            add_jobs(self.folder, self.task.verb, self.option, [job])
            return job
        if known.identity != job.identity:
            raise ConfigError(
                f"Trial {job.number} of the study in {self.shown} was begun with another configuration "
                f"({' '.join(known.overrides)}) than this command gives it ({' '.join(job.overrides)}). Type what "
                "began it, or begin another study: hydra.sweep.dir=…"
            )
        return known

    def _settle(self, study: "SweepStudy", job: SweepJob, status: Status) -> None:
        """Tell the study what came of a trial; of one whose process died, the next command will know more."""
        if status.state == "completed":
            study.tell(job.number, objectives(self.folder / job.folder, self.objective))
        elif status.state == "pruned":
            study.tell_pruned(job.number)
        elif status.state == "failed":
            study.tell(job.number, None)

    def _conclude(self, study: "SweepStudy", unrecorded: dict[int, Status], ended_early: str) -> None:
        jobs = read_jobs(self.folder)
        standing = statuses(self.folder, jobs) | unrecorded
        failed = [job for job in jobs if standing[job.number].state == "failed"]
        if failed:
            print("\n".join([f"{len(failed)} trials failed:", *listed(self.shown, failed, standing)]), file=sys.stderr)
        require_completed(self.shown, [job for job in jobs if job not in failed], standing, ended_early)
        best = study.best()
        if not best:
            completed = any(status.state == "completed" for status in standing.values())
            what = f"reached a finite {', '.join(self.objective)}" if completed else "was completed"
            raise SweepError(f"No trial of the study in {self.shown} {what}; {TABLE_FILE} lists them.")
        entries = [self._described(entry, jobs) for entry in best]
        write_text(self.folder / BEST_FILE, yaml.safe_dump(entries, sort_keys=False, allow_unicode=True))
        print(f"\n{len(study)} trials: {self.shown / TABLE_FILE}. Best, also in {BEST_FILE}:")
        for entry, found in zip(entries, best, strict=True):
            print(f"  trial {entry['trial']}: {_listed(entry['objective'])}  ({_listed(found.values)})")

    def _described(self, best: "Best", jobs: Sequence[SweepJob]) -> dict[str, Any]:
        folder = next(job.folder for job in jobs if job.number == best.number)
        reached = dict(zip(self.objective, best.objectives, strict=True))
        parsed = OverridesParser.create().parse_overrides(_overrides(best.values))  # choices come as they were typed
        values = {key: override.value() for key, override in zip(best.values, parsed, strict=True)}
        return {"trial": best.number, "folder": folder, "objective": reached, "values": values}


def _overrides(values: Mapping[str, object]) -> list[str]:
    return [f"{key}={value}" for key, value in values.items()]


def _listed(values: Mapping[str, object]) -> str:
    return " ".join(_overrides({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in values.items()}))
