"""Teachers that other runs have trained."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ppo.ppo import PPO
from dr_lab.algorithms.teachers.teachers import Teachers
from dr_lab.collectors.experience import Experience
from dr_lab.errors import ConfigError, DataError
from dr_lab.physics.context import ContextSpace
from dr_lab.reports.json_file import typed
from dr_lab.reports.train import TrainReport
from dr_lab.seeding import derived_seed
from dr_lab.training.finished_run import difference, require_run
from dr_lab.training.run_state import RunState
from dr_lab.trajectory import Array

_REMEDY = "Give folders of finished runs of algorithm=ppo in the same env: algorithm.teachers.runs=[FOLDER,…]."


class FinishedTeachers(Teachers):
    """Policies that runs of PPO chose to be deployed; the domain of each is the mean context of its run.

    The runs are read when the training begins. One that goes on has them in its checkpoint. Where they are trained on,
    it is with rates and random numbers of this run.

    Args: as `Teachers`, but for
        runs: their folders, in place of a count.

    Raises:
        ConfigError: there is no run, or the policies cannot share the slots equally.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        learner: Callable[[Interface, int], PPO],
        runs: Sequence[str],
        slots: int,
    ) -> None:
        if not runs:
            raise ConfigError(f"algorithm.teachers.runs is empty; expected one run at least. {_REMEDY}")
        super().__init__(interface, seed, learner, len(runs), slots)
        self._runs, self._seed = runs, seed

    def _draw(self, experience: Experience) -> Array:
        """Read what the runs have left; gives their contexts."""
        folders = [Path(run).expanduser() for run in self._runs]
        for k, (member, folder) in enumerate(zip(self.members, folders, strict=True)):
            _take_over(member, folder, derived_seed(self._seed, "teacher", k))
        self.acting.refresh()
        return np.stack([_domain(folder, experience.space) for folder in folders])


def _take_over(member: PPO, folder: Path, seed: int) -> None:
    """Put PPO into the state of a run, with the policy that it chose."""
    try:
        RunState.load(require_run(folder, "", _REMEDY)).train_on(member, seed)
    except (KeyError, RuntimeError, TypeError, ValueError) as error:
        raise DataError(
            f"The teacher {folder} is a run of another algorithm or has other networks: {difference(error)} {_REMEDY}"
        ) from error


def _domain(folder: Path, space: ContextSpace) -> Array:
    """The mean context of a run, shape (n,)."""
    path = folder / "report.json"
    if not path.is_file():
        raise DataError(f"The teacher {folder} has no report.json: it has not ended. {_REMEDY}")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"The teacher {folder} has a report.json that cannot be read: {error}. {_REMEDY}") from error
    context = typed(TrainReport, content, path).context
    if set(context) != set(space.names):
        raise DataError(
            f"The teacher {folder} was trained in contexts of {', '.join(context) or 'nothing'}; expected "
            f"{', '.join(space.names) or 'nothing'}. {_REMEDY}"
        )
    return np.array([context[name].mean for name in space.names], float)
