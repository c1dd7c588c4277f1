"""The training run that is evaluated: where it is, and its policy as it left it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from dr_lab.algorithms.meta_algorithm import MetaAlgorithm
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.errors import DataError
from dr_lab.evaluators.evaluator import MetaLearner, Subject
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.training.finished_run import difference, require_run
from dr_lab.training.plan import CHECKPOINT, Plan, Training
from dr_lab.training.policy_snapshots import PolicySnapshot, PolicySnapshots
from dr_lab.training.run_state import RunState
from dr_lab.training.trainer import Trainer

Compose = Callable[..., Mapping[str, Any]]
"""Gives the arguments of a verb, built from its name, overrides and the folder that records them."""

_AS_IT_IS = [
    "++plan.device=cpu",  # whatever device the run learnt on, which this machine may lack
    # The distribution is not learnt any more: what it was compared with, such as logs, may be elsewhere by now.
    "++plan.distribution_learner={_target_: dr_lab.distribution_learners.none.NoLearner, _partial_: true}",
]


@dataclass(frozen=True)
class TrainedRun:
    """A training run that is evaluated.

    Attributes:
        run: its folder, or ``latest`` for the newest below `runs`.
        runs: folder that collects training runs.
        threads: C threads of the physics; None takes every core.
    """

    run: str
    runs: str
    threads: int | None

    def folder(self) -> Path:
        """Its folder, by its whole path, which says the same wherever a report of it is read.

        Raises:
            DataError: there is none.
        """
        if self.run == "latest":
            found = sorted(Path(self.runs).rglob(CHECKPOINT), key=lambda path: path.stat().st_mtime)
            if not found:
                raise DataError(
                    f"There is no training run below {self.runs}. Run dr-lab train first, or give run=FOLDER."
                )
            return found[-1].parent.resolve()
        folder = Path(self.run).expanduser()
        return require_run(folder, "", "Give run=FOLDER of a training run, or run=latest.").resolve()


def subject_of(folder: Path, compose: Compose, threads: int | None) -> Subject:
    """The policy of a training run, and what it takes to play it and to train it on.

    Args:
        folder: the training run.
        compose: gives the arguments of a verb.
        threads: C threads of the physics; None takes every core.

    Raises:
        DataError: the checkpoint cannot be read, or is not of what the configuration beside it describes.
    """
    recorded: Plan = compose("train", _AS_IT_IS, recorded=folder, only=["plan"])["plan"]
    plan = replace(recorded, threads=threads)
    training = plan.assemble(None)
    left, snapshots = _restored(training, folder)
    training.trainer.close()

    def fresh(seed: int, further: Plan) -> Training:
        found = replace(further, seed=seed).assemble(None)
        left.train_on(found.algorithm, seed)
        return found

    def again(source: ContextSource, seed: int) -> tuple[Trainer, Policy]:
        found = fresh(seed, replace(plan, randomizer=lambda _: source))
        return found.trainer, found.algorithm.deployed

    def meta_again(seed: int) -> tuple[MetaAlgorithm, Experience]:
        found = fresh(seed, plan)
        return cast(MetaAlgorithm, found.algorithm), found.experience

    learnt = training.algorithm
    meta = MetaLearner(learnt.tasks, meta_again) if isinstance(learnt, MetaAlgorithm) else None
    made = (training.randomizer, snapshots, meta, learnt.domains)
    return Subject(folder.name, plan.env, learnt.deployed, again, threads, *made)


def _restored(training: Training, folder: Path) -> tuple[RunState, list[PolicySnapshot]]:
    """Put algorithm and distribution into the state that a run left; gives that, and the policies that it kept."""
    left, policies = RunState.load(folder), PolicySnapshots(training.algorithm, 0)  # takes none
    try:
        left.restore(training.algorithm)
        training.learner.load_state_dict(left.last["learner"])
        policies.load_state_dict(left.last["policies"])
        snapshots = policies.restored()
    except (KeyError, RuntimeError, TypeError, ValueError) as error:
        raise DataError(
            f"{folder / CHECKPOINT} does not fit {folder / 'config.yaml'}, or is of another version of dr_lab: "
            f"{difference(error)} Give run=FOLDER of a training run as it was left, or train again."
        ) from error
    return left, snapshots
