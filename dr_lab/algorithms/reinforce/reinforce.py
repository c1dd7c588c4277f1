"""REINFORCE: one step along the score-function gradient of whole episodes."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from torch import Tensor

from dr_lab.algorithms.algorithm import Interface
from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.episodic import EpisodicAlgorithm
from dr_lab.algorithms.reinforce.score_function import score
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.bounds import Count, NotNegative, Positive, at_least, at_most, require_bounds
from dr_lab.networks.adam import Adam
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian_actor import GaussianActor


class Reinforce(EpisodicAlgorithm):
    """θ ← θ + η Adam(ĝ) with ĝ = (1/k) Σ_i Σ_t ∇log π(a_t|o_t) (G_t − b_t), G_t the discounted return from t on.

    Source: Williams 1992; with linear policies, Mehta 2020 (thesis), chapter 3.

    Args: as `EpisodicAlgorithm`, with λ = 1, and
        rate: η.
        adam_epsilon: ε of Adam.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        actor: Callable[..., GaussianActor],
        baseline: Baseline,
        slots: Annotated[int, at_least(2)],
        batch_frames: Count,
        gamma: Annotated[float, at_least(0.0), at_most(1.0)],
        rate: Positive,
        adam_epsilon: NotNegative,
    ) -> None:
        super().__init__(interface, seed, actor, baseline, slots, batch_frames, gamma, lam=1.0)
        self.rate, self.adam_epsilon = rate, adam_epsilon
        require_bounds(self, "algorithm", Reinforce)
        self.parameters = FlatParameters(self.actor.parameters())
        self.adam = Adam(self.parameters, adam_epsilon)

    def _step(self, episodes: WholeEpisodes, advantage: Tensor) -> Mapping[str, float]:
        self.parameters.differentiate(-score(dict(self.actor.named_parameters()), self.actor, episodes, advantage))
        self.adam.step(self.rate)
        return {"gradient": self.parameters.gradient.norm().item()}

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {**super().state_dict(), "adam": self.adam.state_dict()}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        super().load_state_dict(state)
        self.adam.load_state_dict(state["adam"])
