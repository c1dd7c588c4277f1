"""The contract of an evaluator: what a trained policy is worth, in contexts of the evaluator's choice."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dr_lab.algorithms.meta_algorithm import MetaAlgorithm
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.envs.environment import Environment
from dr_lab.envs.slots import EpisodeSlots
from dr_lab.errors import ConfigError, DataError
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.randomizers.fixed import FixedRandomizer
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.training import Curve, Gain, Grid, Matrix, Sample, Ways
from dr_lab.seeding import derived_seed
from dr_lab.training.adapting import Adapting, OwnUpdates, TrainingOn
from dr_lab.training.policy_snapshots import PolicySnapshot
from dr_lab.training.rollouts import PolicyRollouts
from dr_lab.training.trainer import Trainer
from dr_lab.trajectory import Array

Row = Mapping[str, float | str]
Progress = Callable[[float], None]


@dataclass(frozen=True)
class MetaLearner:
    """How a policy that was trained to be adapted is adapted.

    Attributes:
        tasks: contexts that it adapts to at once.
        again: gives its algorithm in the trained state, with a random seed, and the experience that it adapts by, which
            is to be closed.
    """

    tasks: int
    again: Callable[[int], tuple[MetaAlgorithm, Experience]]


@dataclass(frozen=True)
class Subject:
    """A trained policy and what it was trained on.

    Attributes:
        name: of the run.
        setting: machine and task.
        policy: what is deployed: without exploration.
        again: gives a trainer that goes on from the trained state, on contexts from another source, with a random seed,
            and the policy that it trains; it leaves no checkpoint, and is to be closed.
        threads: C threads of the physics; None takes every core.
        trained_on: distribution of the contexts, as training left it; None for the nominal context alone.
        snapshots: the policies that training had last, oldest first.
        meta: how a policy is adapted that was trained for it; None where adapting is training on.
        domains: contexts on which it was trained where these stayed the same, shape (N, n); None where there are none.
    """

    name: str
    setting: Environment
    policy: Policy
    again: Callable[[ContextSource, int], tuple[Trainer, Policy]]
    threads: int | None = None
    trained_on: ContextSource | None = None
    snapshots: Sequence[PolicySnapshot] = ()
    meta: MetaLearner | None = None
    domains: Array | None = None

    @property
    def together(self) -> int:
        """Contexts that `adapting` takes at once."""
        return 1 if self.meta is None else self.meta.tasks

    def adapting(self, z: Array, frames: int, seed: int) -> Adapting:
        """The trained policy, to be adapted to contexts.

        Args:
            z: contexts, shape (`together`, n).
            frames: control steps of an update where adapting is training on; a meta-learner knows what it takes.
            seed: of its random draws.

        Returns:
            What is to be closed.

        Raises:
            ConfigError: it was trained on contexts that stay the same, and would go on in these.
        """
        if self.domains is not None:
            raise ConfigError(
                f"Run {self.name} was trained on the same {len(self.domains)} contexts throughout, as DiDoR and "
                "ensembles are, and would be trained on in these, not in the contexts of the evaluator. "
                "evaluator=unseen_domains plays it in other contexts. To train on in each, give run=FOLDER of an "
                "algorithm whose episodes draw their contexts, such as algorithm=ppo."
            )
        if self.meta is not None:
            return OwnUpdates(*self.meta.again(seed), z)
        (values,) = z
        fixed = FixedRandomizer(self.setting.space, self.setting.space.mapping(values))
        return TrainingOn(*self.again(fixed, seed), frames)

    def rollouts(self, episodes: int, seed: int, policy: Policy | None = None) -> PolicyRollouts:
        """Whole episodes, so many side by side, of the policy or of another one on the same task."""
        return PolicyRollouts(self.slots(episodes, seed), policy or self.policy)

    def contexts(self, count: int, rng: np.random.Generator) -> Array:
        """Draws of the distribution that was trained on, shape (count, n)."""
        if self.trained_on is None:
            return np.tile(self.setting.space.nominal, (count, 1))
        return self.trained_on.propose([rng] * count, np.arange(count)).z

    def kept(self) -> Sequence[PolicySnapshot]:
        """The snapshots, one at least.

        Raises:
            DataError: there is none.
        """
        if not self.snapshots:
            raise DataError(f"Run {self.name} has kept no policy yet. Give run=FOLDER of one that has saved some.")
        return self.snapshots

    def slots(self, episodes: int, seed: int) -> EpisodeSlots:
        """Slots of the task, side by side, whose starts are not those that training drew from the same seed."""
        return self.setting.make(None, episodes, derived_seed(seed, "evaluation"), self.threads).episodes


class Table(NamedTuple):
    """Rows with the same keys.

    Attributes:
        file: name in the run folder, which holds all of it.
        rows: in the order in which they are read.
        shown: the columns that a page shows; None shows all.
    """

    file: str
    rows: Sequence[Row]
    shown: Sequence[str] | None = None

    def on_page(self) -> Sequence[Row]:
        """The rows as a page shows them."""
        return self.rows if self.shown is None else [{name: row[name] for name in self.shown} for row in self.rows]


@dataclass(frozen=True)
class Evaluation:
    """What an evaluator found.

    Attributes:
        figures: what a reader wants to know first, by name.
        rows: the table behind them, one row a context, policy or whatever the evaluator compares; same keys in each.
        units: of the columns of the table and of the summary that have one.
        grids: returns over contexts.
        matrices: cosines between the gradients of contexts, the most telling first.
        curves: figures over the control steps of training.
        gains: what updates add to the return over contexts, the most telling first.
        ways: of the policy in the plane, before and after updates.
        samples: returns whose scatter is looked at, side by side.
        episodes: that are worth being looked at.
        summary: a shorter table, which a page shows in place of the rows; None shows these.
        told: what was played and what the figures mean, for the page.
    """

    figures: Mapping[str, float]
    rows: Sequence[Row]
    units: Mapping[str, str] = field(default_factory=dict)
    grids: Sequence[Grid] = field(default_factory=tuple)
    matrices: Sequence[Matrix] = field(default_factory=tuple)
    curves: Sequence[Curve] = field(default_factory=tuple)
    gains: Sequence[Gain] = field(default_factory=tuple)
    ways: Sequence[Ways] = field(default_factory=tuple)
    samples: Sequence[Sample] = field(default_factory=tuple)
    episodes: Sequence[Episode] = field(default_factory=tuple)
    summary: Table | None = None
    told: str = ""


class Evaluator(ABC):
    """Plays a trained policy and sums up what it returns."""

    @abstractmethod
    def evaluate(self, subject: Subject, folder: Path, progress: Progress) -> Evaluation:
        """Evaluate.

        Args:
            subject: what is evaluated.
            folder: for files of its own.
            progress: is told the share that is done, from 0 to 1.
        """
