"""Policies that go on learning, each in a context of its own: what adaptation means, whatever learns."""

from abc import ABC, abstractmethod

import numpy as np
from tensordict import TensorDict

from dr_lab.algorithms.meta_algorithm import MetaAlgorithm
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.errors import ConfigError
from dr_lab.randomizers.context_source import UNKEYED, Proposals
from dr_lab.training.trainer import Trainer
from dr_lab.trajectory import Array


class Adapting(ABC):
    """Policies that are adapted to T contexts, update by update.

    Attributes:
        policy: acts without exploration as the policies are then; of n slots, that of context k for those from k·n/T up
            to (k + 1)·n/T.
    """

    policy: Policy

    @property
    @abstractmethod
    def frames(self) -> int:
        """Control steps that the adaptation has taken so far, in all contexts together."""

    @abstractmethod
    def update(self) -> None:
        """Adapt them once more."""

    @abstractmethod
    def close(self) -> None:
        """End what collects experience."""


class TrainingOn(Adapting):
    """An algorithm trains on in one context; an update is what it learns from so many control steps.

    Args:
        trainer: begins in that context from the trained state; closed in the end.
        policy: what it trains, without exploration.
        frames: control steps of an update, which ends with a whole batch.
    """

    def __init__(self, trainer: Trainer, policy: Policy, frames: int) -> None:
        self.policy = policy
        self._trainer, self._each = trainer, frames
        self._begun, self._updates = trainer.frames, 0

    @property
    def frames(self) -> int:
        """Control steps trained."""
        return self._trainer.frames - self._begun

    def update(self) -> None:
        """Train on.

        Raises:
            ConfigError: it is so short that nothing is trained.
        """
        before = self.frames
        self._updates += 1
        self._trainer.run(self._begun + self._updates * self._each, lambda *_: None)
        if self.frames == before:
            batch = self.frames // (self._updates - 1)
            raise ConfigError(
                f"evaluator.frames is {self._each}, less than a batch of {batch} control steps, so that update "
                f"{self._updates} trains nothing. Give evaluator.frames={batch} or more."
            )

    def close(self) -> None:
        """End what the trainer keeps running."""
        self._trainer.close()


class OwnUpdates(Adapting):
    """A meta-learner's policy, adapted in the way that it was trained for.

    Args:
        algorithm: the meta-learner.
        experience: collects with its policies.
        z: contexts, as many as it adapts to at once, shape (T, n).
    """

    def __init__(self, algorithm: MetaAlgorithm, experience: Experience, z: Array) -> None:
        self.policy = algorithm.adapted_policies.mean
        self._algorithm, self._experience = algorithm, experience
        self._tasks = Proposals(z, np.full(len(z), UNKEYED, np.int64))
        self._updates, self._collected = 0, 0
        experience.listen(self._count)
        algorithm.begin_adapting()

    @property
    def frames(self) -> int:
        """Control steps collected."""
        return self._collected

    def update(self) -> None:
        """Play with the policies as they are, and learn from it."""
        self._algorithm.adapt_once(self._experience, self._tasks, self._updates)
        self._updates += 1

    def close(self) -> None:
        """End what collects."""
        self._experience.close()

    def _count(self, batch: TensorDict) -> None:
        self._collected += batch.numel()
