"""Training that begins with what an earlier run learnt."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.errors import DataError
from dr_lab.training.checkpoint import load
from dr_lab.training.plan import CHECKPOINT, Training


@dataclass(frozen=True)
class Beginning:
    """What a new run takes over from a finished one; all else, random numbers and counters included, is its own.

    Attributes:
        run: folder of the finished run, of the same algorithm on the same observations and actions; None takes nothing
            over.
        distribution: whether p(z), and what shapes it, is taken over; randomizer and learner are to be the same.
        policy: whether the policy and its normaliser are.
    """

    run: str | None
    distribution: bool
    policy: bool = True

    def apply(self, training: Training, seed: int) -> None:
        """Put a training that has not begun into the state that the finished run left.

        Args:
            training: the new run.
            seed: of its random numbers.

        Raises:
            DataError: there is no such run, or its networks or its distribution are others.
        """
        if self.run is None:
            return
        folder = Path(self.run).expanduser()
        saved = load(folder / CHECKPOINT)
        try:
            if self.policy:
                go_on_from(training.algorithm, saved["algorithm"], seed)
            if self.distribution:
                training.learner.inherit(saved["learner"])
        except (KeyError, RuntimeError, TypeError, ValueError) as error:
            raise DataError(
                f"init={self.run} is a run with another algorithm, other networks or another distribution: "
                f"{' '.join(str(error).split())} Give algorithm, env and, with init_distribution=true, randomizer and "
                f"distribution_learner as in {folder / 'config.yaml'}."
            ) from error


def go_on_from(algorithm: Algorithm, state: Mapping[str, Any], seed: int) -> None:
    """Let an algorithm learn on from what another run of it learnt, on episodes of its own.

    Args:
        algorithm: a new one.
        state: that the other run left.
        seed: of the new one's random numbers.
    """
    algorithm.load_state_dict(state)
    algorithm.explore_anew(seed)
    algorithm.begin_schedules()
    algorithm.forget_episodes()  # those of the other run ended with it
