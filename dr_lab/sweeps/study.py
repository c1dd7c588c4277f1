"""A study in the folder of a sweep: which values to try next, and what came of those that were tried.

Optuna proposes, its journal keeps the account, so that a study that was killed goes on where it was. Every proposal is
drawn from a random stream of its own, by the seed and the number of the trial: a study that was continued tries the
same values as one that never stopped, where trials are tried one after the other.
"""

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import optuna
from filelock import FileLock
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution, IntDistribution
from optuna.pruners import BasePruner
from optuna.samplers import BaseSampler
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend, JournalFileOpenLock
from optuna.study import StudyDirection
from optuna.trial import Trial, TrialState

from dr_lab.errors import ConfigError
from dr_lab.sweeps.progress import Pruned
from dr_lab.sweeps.sweep import JOURNAL_FILE

_LOCK_FILE = ".study.lock"
_NAME = "study"
_OBJECTIVE, _EXHAUSTED = "objective", "exhausted"  # attributes of the study

Value = str | int | float | bool | None
Sampler = Callable[..., BaseSampler]

optuna.logging.set_verbosity(optuna.logging.WARNING)


@dataclass(frozen=True)
class Proposal:
    """Values to be tried.

    Attributes:
        number: of the trial.
        values: by key.
    """

    number: int
    values: Mapping[str, Value]


@dataclass(frozen=True)
class Best:
    """A trial that no other one beats in every objective.

    Attributes:
        number: of the trial.
        objectives: what it reached.
        values: what was tried, by key.
    """

    number: int
    objectives: tuple[float, ...]
    values: Mapping[str, Value]


class SweepStudy:
    """The account of a study; begins it where there is none.

    Args:
        folder: of the sweep.
        objective: keys of what is judged; may be corrected until a trial has succeeded.
        directions: ``minimize`` or ``maximize`` for each of them.
        space: what may be tried, by key.
        sampler: makes Optuna's sampler from a ``seed``.
        seed: of all proposals.

    Attributes:
        exhausted: the sampler has tried everything in the space, in this command or an earlier one.

    Raises:
        ConfigError: the study in the folder has other objectives.
    """

    def __init__(
        self,
        folder: Path,
        objective: Sequence[str],
        directions: Sequence[str],
        space: Mapping[str, BaseDistribution],
        sampler: Sampler,
        seed: int,
    ) -> None:
        self._storage = _storage(folder)
        asked = [StudyDirection[direction.upper()] for direction in directions]
        self._study = optuna.create_study(
            study_name=_NAME, storage=self._storage, directions=asked, load_if_exists=True
        )
        found = self._study.user_attrs | {"directions": [each.name.lower() for each in self._study.directions]}
        for key, value in {"directions": list(directions), _OBJECTIVE: list(objective)}.items():
            if found.get(key, value) != value:
                raise ConfigError(
                    f"The study in {folder} has {key}={found[key]}, not {value}. Keep them, or begin another study: "
                    "hydra.sweep.dir=…"
                )
        self._whole = f"{type(sampler(seed=seed)).__name__} of {dict(space)}"
        self.exhausted = found.get(_EXHAUSTED) == self._whole
        self._objective = list(objective)
        self._folder, self._space, self._sampler, self._seed = folder, space, sampler, seed

    def __len__(self) -> int:
        """How many trials there are, in whatever state."""
        return len(self._study.get_trials(deepcopy=False))

    def unfinished(self) -> list[Proposal]:
        """The trials whose outcome is not known, for one because an earlier command was killed."""
        running = self._study.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
        return [self._complete(trial.number) for trial in running]

    def propose(self) -> Proposal:
        """Begin another trial.

        Raises:
            ConfigError: the study in the folder is about another space.
        """
        self._draw_for(len(self))
        return self._proposal(self._study.ask())

    def tell(self, number: int, objectives: Sequence[float] | None) -> None:
        """Say what came of a trial.

        Args:
            number: of the trial.
            objectives: what it reached; None where it failed.
        """
        if objectives is None or not all(map(math.isfinite, objectives)):
            self._end(number, state=TrialState.FAIL)
        else:
            if _OBJECTIVE not in self._study.user_attrs:
                self._study.set_user_attr(_OBJECTIVE, self._objective)
            self._end(number, values=list(objectives))

    def tell_pruned(self, number: int) -> None:
        """Say that a trial was given up; what it had reached counts."""
        self._end(number, state=TrialState.PRUNED)

    def _end(self, number: int, values: list[float] | None = None, state: TrialState | None = None) -> None:
        try:
            self._study.tell(number, values=values, state=state)
        except RuntimeError as error:
            # How a sampler of finitely many values says that all have been tried; the trial has been written down.
            if "Study.stop" not in str(error):
                raise
            self.exhausted = True
            self._study.set_user_attr(_EXHAUSTED, self._whole)

    def best(self) -> list[Best]:
        """The trials that none beats in every objective; one of them where there is a single objective."""
        trials = [t for t in self._study.best_trials if t.values is not None]
        found = [Best(trial.number, tuple(trial.values), dict(trial.params)) for trial in trials]
        return found[:1] if len(self._study.directions) == 1 else found

    def _draw_for(self, number: int) -> None:
        stream = np.random.SeedSequence([self._seed, number])
        self._study.sampler = self._sampler(seed=int(stream.generate_state(1)[0]))

    def _complete(self, number: int) -> Proposal:
        """A trial that is begun, with all its values: the process may have been killed while it drew them."""
        self._draw_for(number)
        study_id = self._storage.get_study_id_from_name(_NAME)
        return self._proposal(
            Trial(self._study, self._storage.get_trial_id_from_study_id_trial_number(study_id, number))
        )

    def _proposal(self, trial: Trial) -> Proposal:
        try:
            values = {key: _suggested(trial, key, distribution) for key, distribution in self._space.items()}
        except ValueError as error:
            raise ConfigError(
                f"The study in {self._folder} is about another search space: {error} Keep the space, or begin another "
                "study: hydra.sweep.dir=…"
            ) from error
        return Proposal(trial.number, values)


class Pruning:
    """Lets a study's pruner see how one of its trials stands, from the process where that trial runs.

    Args:
        folder: of the sweep.
        number: of the trial.
        pruner: Optuna's.
        key: figure that it judges by.
    """

    def __init__(self, folder: Path, number: int, pruner: BasePruner, key: str) -> None:
        self._storage = _storage(folder)
        self._study = optuna.load_study(study_name=_NAME, storage=self._storage, pruner=pruner)
        study_id = self._storage.get_study_id_from_name(_NAME)
        self._trial = self._storage.get_trial_id_from_study_id_trial_number(study_id, number)
        self._key = key

    def __call__(self, step: int, figures: Mapping[str, float]) -> None:
        """Take the figures of a step.

        Raises:
            ConfigError: the figure that the pruner judges by is not among them.
            Pruned: the pruner gives the trial up.
        """
        if self._key not in figures:
            raise ConfigError(f"prune_on={self._key} is no figure of this run. Available: {', '.join(figures)}.")
        if not math.isfinite(figures[self._key]):
            return
        self._storage.set_trial_intermediate_value(self._trial, step, float(figures[self._key]))
        if self._study.pruner.prune(self._study, self._storage.get_trial(self._trial)):
            raise Pruned


class _KernelLock(JournalFileOpenLock):
    """The journal's lock; unlike Optuna's own it goes with the process that holds it, and its holder finds whole lines.

    Args:
        path: of the lock.
        journal: that it guards; whoever adds lines holds it.
    """

    def __init__(self, path: Path, journal: Path) -> None:
        super().__init__(str(path))
        self._lock, self._journal = FileLock(path), journal

    def acquire(self) -> bool:
        self._lock.acquire()
        _mend(self._journal)
        return True

    def release(self) -> None:
        self._lock.release()


def _storage(folder: Path) -> JournalStorage:
    journal = folder / JOURNAL_FILE
    return JournalStorage(JournalFileBackend(str(journal), _KernelLock(folder / _LOCK_FILE, journal)))


def _mend(journal: Path) -> None:
    """Cut off a last line that a full disk left half-written; no later one could be read after it."""
    with journal.open("r+b") as file:
        if file.seek(0, os.SEEK_END) == 0:
            return
        file.seek(-1, os.SEEK_END)
        if file.read() != b"\n":  # asked at every line that is added, so only a broken journal is read as a whole
            file.seek(0)
            file.truncate(file.read().rfind(b"\n") + 1)


def _suggested(trial: Trial, key: str, distribution: BaseDistribution) -> Value:
    if isinstance(distribution, FloatDistribution):
        return trial.suggest_float(
            key, distribution.low, distribution.high, step=distribution.step, log=distribution.log
        )
    if isinstance(distribution, IntDistribution):
        return trial.suggest_int(key, distribution.low, distribution.high, step=distribution.step, log=distribution.log)
    assert isinstance(distribution, CategoricalDistribution)
    return trial.suggest_categorical(key, distribution.choices)
