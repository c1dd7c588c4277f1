"""Policies of many domains that act together."""

from collections.abc import Callable, Mapping

from tensordict import TensorDict

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.ensemble.mean_policy import MeanPolicy
from dr_lab.algorithms.teachers.taught import Taught
from dr_lab.algorithms.teachers.teachers import Teachers
from dr_lab.bounds import Count, require_bounds
from dr_lab.collectors.collector import Policy


class Ensemble(Taught):
    """Trains N policies, each in one domain, and deploys the mean of their actions.

    Every iteration collects a whole episode in each slot.

    Source: Brosseit et al., Distilled Domain Randomization, 2021, §V, second baseline.

    Args:
        interface: what the policies are connected to.
        seed: of everything that is random.
        teachers: makes the policies, from interface and seed.
        batch_frames: control steps that are collected at once until every slot has ended an episode.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self, interface: Interface, seed: int, teachers: Callable[[Interface, int], Teachers], batch_frames: Count
    ) -> None:
        self.batch_frames = batch_frames
        require_bounds(self, "algorithm", Ensemble)
        super().__init__(interface, seed, teachers)
        self._mean = MeanPolicy(self.teachers.acting)

    @property
    def policies(self) -> Mapping[str, Policy]:
        """The mean of all, which does not explore."""
        return {"policy": self._mean}

    @property
    def collecting(self) -> Policy:
        """Each policy, for its own slots."""
        return self.teachers.acting

    @property
    def deployed(self) -> Policy:
        """The mean of all."""
        return self._mean

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Let every policy learn from its own slots."""
        return self.teachers.update(batch)
