"""A curriculum: training first on one distribution, then on another."""

from collections.abc import Mapping, Sequence
from typing import Any

from tensordict import TensorDict

from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.errors import ConfigError
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.randomizers.staged import StagedRandomizer


class Curriculum(DistributionLearner):
    """Goes through stages of equal length: after n of N control steps it is stage ⌊n·k/N⌋ of k.

    Episodes that run when a stage ends keep their context; those that begin then are of the next.

    Source: Mehta 2020 (thesis), §3.1, where each of two stages lasts half of the training.

    Args:
        randomizer: p(z), a `StagedRandomizer`.
        seed: of nothing; every learner is made alike.
        order: names of the stages, in which training goes through them; one that is named twice lasts twice as long.
        frames: N, control steps of the run.

    Raises:
        ConfigError: the randomizer has no stages, or `order` is empty.
        UnknownNameError: it has others.
    """

    def __init__(self, randomizer: Randomizer, seed: int, order: Sequence[str], frames: int) -> None:
        del seed
        if not isinstance(randomizer, StagedRandomizer):
            raise ConfigError(
                f"distribution_learner=curriculum goes through stages, which {type(randomizer).__name__} does not "
                "have. Take randomizer=staged."
            )
        if not order:
            raise ConfigError(
                "distribution_learner.order is empty; expected names of stages, of "
                f"{', '.join(randomizer.names)}: distribution_learner.order=[{','.join(randomizer.names)}]"
            )
        super().__init__(randomizer)
        self.staged, self.order, self.frames = randomizer, tuple(order), frames
        self.seen = 0
        for stage in (*self.order, self.order[0]):
            randomizer.enter(stage)

    @property
    def learns(self) -> bool:
        """It changes, so that pictures follow it."""
        return True

    @property
    def stage(self) -> int:
        """Place in `order` of what is trained on."""
        return min(self.seen * len(self.order) // self.frames, len(self.order) - 1)

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """Go on to the next stage where its time has come; gives the stage that new episodes are of."""
        del experience
        self.seen += batch.numel()
        self.staged.enter(self.order[self.stage])
        return {"stage": float(self.stage)}

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return super().state_dict() | {"seen": self.seen}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.seen = state["seen"]

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Begin with the stages as another run's `state_dict` holds them, in the first one of this run."""
        super().inherit(state)
        self.staged.enter(self.order[0])
