"""Trust-region policy optimisation on whole episodes."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

import torch
from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.episodic import EpisodicAlgorithm
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.algorithms.trpo.own_policy import OwnPolicy
from dr_lab.algorithms.trpo.policy_rows import policy_rows
from dr_lab.algorithms.trpo.policy_step import PolicyStep
from dr_lab.bounds import Count, at_least, at_most, require_bounds
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian_actor import GaussianActor


class TRPO(EpisodicAlgorithm):
    """One step on each batch of whole episodes, as far as a bound on the divergence allows (Schulman et al. 2015).

    Args: as `EpisodicAlgorithm`, and
        step: makes what moves the policy, from its parameters.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        actor: Callable[..., GaussianActor],
        baseline: Baseline,
        step: Callable[[FlatParameters], PolicyStep],
        slots: Annotated[int, at_least(2)],
        batch_frames: Count,
        gamma: Annotated[float, at_least(0.0), at_most(1.0)],
        lam: Annotated[float, at_least(0.0), at_most(1.0)],
    ) -> None:
        super().__init__(interface, seed, actor, baseline, slots, batch_frames, gamma, lam)
        require_bounds(self, "algorithm", TRPO)
        self._like = dict(self.actor.named_parameters())
        self.step = step(FlatParameters(self._like.values()))

    def _step(self, episodes: WholeEpisodes, advantage: Tensor) -> Mapping[str, float]:
        policy_at = OwnPolicy(self.actor, self._like, episodes.observation.flatten(0, 1))
        with torch.no_grad():
            rows = policy_rows(episodes, policy_at(self.step.parameters.vector), advantage)
        return self.step(policy_at, rows)

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {**super().state_dict(), "step": self.step.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.step.load_state_dict(state["step"])
