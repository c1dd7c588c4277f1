"""REINFORCE: one step along the score-function gradient of whole episodes."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.score_function import score
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes, whole_episodes
from dr_lab.bounds import Count, NotNegative, Positive, at_least, at_most, require_bounds
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.networks.adam import Adam
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.seeding import derived_seed, stream


class Reinforce(Algorithm):
    """θ ← θ + η Adam(ĝ) with ĝ = (1/k) Σ_i Σ_t ∇log π(a_t|o_t) (G_t − b_t), G_t the discounted return from t on.

    An iteration draws a context for each slot from p(z) and plays one whole episode in it; what a slot plays after its
    first episode is not learnt from. Episodes in infeasible contexts are not learnt from either.

    Source: Williams 1992; with linear policies, Mehta 2020 (thesis), chapter 3.

    Args:
        interface: what the policy is connected to.
        seed: of the network, actions and contexts.
        actor: makes the policy, from observation width, bounds and seed; without hidden layers it is linear.
        baseline: gives b_t.
        slots: k, episodes side by side.
        batch_frames: control steps that are collected at once until every slot has ended an episode.
        gamma: discount per control step.
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
        self.baseline, self.slots, self.batch_frames = baseline, slots, batch_frames
        self.gamma, self.rate = gamma, rate
        self.adam_epsilon = adam_epsilon
        require_bounds(self, "algorithm", Reinforce)
        self.actor = actor(interface.observation, interface.low, interface.high, derived_seed(seed, "actor"))
        self.parameters = FlatParameters(self.actor.parameters())
        self.adam = Adam(self.parameters, adam_epsilon)
        self.rng = stream(seed, "reinforce")

    @property
    def policies(self) -> Mapping[str, Policy]:
        """The stochastic policy."""
        return {"policy": self.actor}

    @property
    def deployed(self) -> Policy:
        """Its most likely action."""
        return self.actor.mean

    def iterate(self, experience: Experience) -> Mapping[str, float]:
        """Play new contexts, one episode in each slot, and learn from these."""
        return self.update(experience.collect_whole(experience.contexts(self.rng, self.slots)))

    def update(self, batch: TensorDict) -> Mapping[str, float]:
        """One step; the normaliser is renewed after it, so that the policy is the one that acted.

        Args:
            batch: as `Experience.collect_whole` gives it.
        """
        first = first_episodes(batch)
        episodes = whole_episodes(batch, first, self.actor)
        figures = self._step(episodes) if len(episodes.reward) else {}
        self.actor.normaliser.update(cast(Tensor, batch["observation"])[first])
        return {"episodes_learnt": float(len(episodes.reward)), **figures}

    def _step(self, episodes: WholeEpisodes) -> Mapping[str, float]:
        to_go = episodes.returns_to_go(self.gamma)
        advantage = to_go - self.baseline(episodes, to_go)
        self.parameters.differentiate(-score(dict(self.actor.named_parameters()), self.actor, episodes, advantage))
        self.adam.step(self.rate)
        lived = episodes.mask > 0
        return {
            "gradient": self.parameters.gradient.norm().item(),
            "explained": 1.0 - (advantage[lived].var() / to_go[lived].var()).item(),
            "std": self.actor.log_std.exp().mean().item(),
        }

    def explore_anew(self, seed: int) -> None:
        """Draw actions and contexts by other random numbers."""
        super().explore_anew(seed)
        self.rng = stream(seed, "explore_anew", "reinforce")

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "actor": self.actor.state_dict(),
            "adam": self.adam.state_dict(),
            "rng": self.rng.bit_generator.state,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.actor.load_state_dict(state["actor"])
        self.adam.load_state_dict(state["adam"])
        self.rng.bit_generator.state = state["rng"]
