"""The loop that all algorithms share."""

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from tensordict import TensorDict

from dr_lab.algorithms.algorithm import Algorithm
from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.errors import DataError, DrLabError
from dr_lab.training.checkpoint import load, not_finite, save
from dr_lab.training.episode_log import EpisodeLog, Finished, joined

BatchWatch = Callable[[Mapping[str, float], Finished], None]


class Stateful(Protocol):
    """What a checkpoint can hold."""

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        ...

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        ...


class Trainer:
    """Collect, shape the distribution, learn, record, save; over and over.

    As in Mozifian et al. 2020, algorithm 1, the distribution is updated between collection and learning: with a batch,
    before the algorithm has it.

    Args:
        experience: of the algorithm's policy.
        algorithm: learns the policy.
        learner: learns the distribution that the collected contexts are drawn from.
        checkpoint: the file that a later run continues from; None keeps none.
        every: control steps between two checkpoints, which wait for an iteration to end.
        more: what else the checkpoint shall hold, by name, such as what `watch` keeps.
        time_limit: control steps of a whole episode; of what was cut before no return is known.

    Attributes:
        history: figures of every iteration so far.
    """

    def __init__(
        self,
        experience: Experience,
        algorithm: Algorithm,
        learner: DistributionLearner,
        checkpoint: Path | None,
        every: int,
        more: Mapping[str, Stateful] | None = None,
        time_limit: int = 0,
    ) -> None:
        self._experience = experience
        self._algorithm = algorithm
        self._learner = learner
        self._episodes = EpisodeLog(time_limit)
        self._checkpoint = checkpoint
        self._every = every
        self._more = more if more is not None else {}
        self.history: list[dict[str, float]] = []
        self._collected = 0  # in the iteration that runs
        self._finished: list[Finished] = []  # in it
        self._shaped: dict[str, float] = {}  # in it
        experience.listen(self._take)

    @property
    def frames(self) -> int:
        """Control steps collected so far."""
        return int(self.history[-1]["frames"]) if self.history else 0

    @property
    def due(self) -> bool:
        """Whether the newest iteration has passed a multiple of `every`, so that a checkpoint is due."""
        before = int(self.history[-2]["frames"]) if len(self.history) > 1 else 0
        return self.frames // self._every > before // self._every

    def run(self, frames: int, watch: BatchWatch) -> None:
        """Train until so many control steps were collected in all, then save.

        An interruption, Ctrl-C or kill -9, leaves the last checkpoint, from which `resume` goes on.

        Args:
            frames: control steps, those before a `resume` included.
            watch: gets the figures of every iteration and the episodes that ended in it.

        Raises:
            DrLabError: the checkpoint cannot be written, or what was learnt is not finite, which is not saved.
        """
        if self.frames >= frames:
            self._save()  # of a run that was resumed at its end, so that its new folder holds what it learnt
        while self.frames < frames:
            figures, finished = self._iterate()
            self.history.append(figures)
            watch(figures, finished)
            if self.due or self.frames >= frames:
                self._save()

    def close(self) -> None:
        """End what the collector keeps running, such as workers on other machines."""
        self._experience.close()

    def resume(self, checkpoint: Path) -> None:
        """Go on as if the run that wrote this checkpoint had never been interrupted.

        Raises:
            DataError: the file cannot be read, or belongs to a run with other settings.
        """
        state = load(checkpoint)
        try:
            self.load_state_dict(state)
        except (KeyError, RuntimeError, TypeError, ValueError) as error:
            raise DataError(f"{checkpoint} is of a run with other settings: {error}") from error

    def _save(self) -> None:
        state = self.state_dict()
        lost = next((name for part in ("algorithm", "learner") for name in not_finite(state[part], part)), None)
        if lost is not None:
            raise DrLabError(
                f"After {self.frames} control steps {lost} is no longer finite: training has diverged, and is not "
                "saved. Lower the learning rates of the algorithm, or look for a reward or an observation of the task "
                "that is not finite."
            )
        if self._checkpoint is not None:
            save(self._checkpoint, state)

    def _iterate(self) -> tuple[dict[str, float], Finished]:
        begin = time.monotonic()
        self._collected, self._finished, self._shaped = 0, [], {}
        learnt = self._algorithm.iterate(self._experience)
        finished = joined(self._finished)
        before = self.history[-1]["seconds"] if self.history else 0.0
        figures = {
            "iteration": float(len(self.history) + 1),
            "frames": float(self.frames + self._collected),
            "rollout_frames": float(self._experience.rollout_frames),
            "seconds": before + time.monotonic() - begin,
            **finished.figures(),
            **learnt,
            **self._shaped,
        }
        return figures, finished

    def _take(self, batch: TensorDict) -> None:
        """Note what ended in a batch, and let the learner shape the distribution where its turn has come."""
        self._finished.append(self._episodes.take(batch))
        before, learner = self.frames + self._collected, self._learner
        seen = before + batch.numel()
        self._collected += batch.numel()
        if seen >= learner.first and seen // learner.every > before // learner.every:
            self._shaped |= learner.update(batch, self._experience)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        parts = {name: part.state_dict() for name, part in self._parts().items()}
        return {**parts, "history": self.history}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        for name, part in self._parts().items():
            part.load_state_dict(state[name])
        self.history = list(state["history"])

    def _parts(self) -> dict[str, Stateful]:
        return {
            "algorithm": self._algorithm,
            "learner": self._learner,
            "experience": self._experience,
            "episodes": self._episodes,
            **self._more,
        }
