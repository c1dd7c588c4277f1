"""Policies of many domains that act together."""

from collections.abc import Callable, Mapping
from typing import Any

from tensordict import TensorDict

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.didor.teachers import Teachers
from dr_lab.algorithms.ensemble.mean_policy import MeanPolicy
from dr_lab.bounds import Count, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.trajectory import Array


class Ensemble(Algorithm):
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
        self.teachers = teachers(interface, seed)
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

    @property
    def domains(self) -> Array | None:
        """The contexts that the policies are trained in, shape (N, n); None before they are drawn."""
        return self.teachers.domains

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """Play a whole episode in each slot, and learn from it."""
        return self.update(experience.collect_whole(self.teachers.slot_contexts(experience)))

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """Let every policy learn from its own slots."""
        return self.teachers.update(batch)

    def begin_schedules(self) -> None:
        """Those of the policies."""
        self.teachers.begin_schedules()

    def forget_episodes(self) -> None:
        """Those of the policies."""
        self.teachers.forget_episodes()

    def explore_anew(self, seed: int) -> None:
        """As every policy does."""
        self.teachers.explore_anew(seed)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {"teachers": self.teachers.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.teachers.load_state_dict(state["teachers"])
