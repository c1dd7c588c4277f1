"""No learning: domain randomisation with a fixed distribution."""

from collections.abc import Mapping

from tensordict import TensorDict

from dr_lab.collectors.experience import Experience
from dr_lab.distribution_learners.distribution_learner import DistributionLearner
from dr_lab.randomizers.randomizer import Randomizer


class NoLearner(DistributionLearner):
    """Leaves p(z) as it is and plays no episodes.

    Args:
        randomizer: p(z).
        seed: of nothing; every learner is made alike.
    """

    def __init__(self, randomizer: Randomizer, seed: int) -> None:
        del seed
        super().__init__(randomizer)

    @property
    def learns(self) -> bool:
        """Never, whatever the family of p(z) could."""
        return False

    def update(self, batch: TensorDict, experience: Experience) -> Mapping[str, float]:
        """Nothing."""
        del batch, experience
        return {}
