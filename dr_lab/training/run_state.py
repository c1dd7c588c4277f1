"""What a training run has left in its folder."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.training.checkpoint import load
from dr_lab.training.plan import CHECKPOINT, POLICY
from dr_lab.training.policy_snapshots import load_states


@dataclass(frozen=True)
class RunState:
    """The state in which a run was left, and the policy that it chose to be deployed.

    Attributes:
        last: the last checkpoint.
        chosen: the snapshot of the chosen policy; None of a run that has not ended, whose last policy stands.
    """

    last: Mapping[str, Any]
    chosen: Mapping[str, Any] | None

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read a run folder.

        Raises:
            DataError: it holds no readable checkpoint.
        """
        chosen = load(folder / POLICY) if (folder / POLICY).is_file() else None
        return cls(load(folder / CHECKPOINT), chosen)

    def restore(self, algorithm: Algorithm) -> None:
        """Put an algorithm into the last state, but with the chosen policy.

        The policy comes with its normaliser. Value networks, optimisers, buffers and counters are the last ones: a run
        keeps no earlier ones.

        Args:
            algorithm: the same as that of the run, with the same networks.
        """
        algorithm.load_state_dict(self.last["algorithm"])
        if self.chosen is not None:
            load_states(algorithm, self.chosen["policies"])

    def train_on(self, algorithm: Algorithm, seed: int) -> None:
        """Let a new algorithm learn on from here, on episodes and by random numbers of its own.

        It begins as `restore` says, with its schedules, random numbers and counters new.

        Args:
            algorithm: the same as that of the run, with the same networks.
            seed: of its random numbers.
        """
        self.restore(algorithm)
        algorithm.explore_anew(seed)
        algorithm.begin_schedules()
        algorithm.forget_episodes()  # those of the run ended with it
