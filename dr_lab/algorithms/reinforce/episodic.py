"""What algorithms have in common that learn from whole episodes with a baseline."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, cast

from tensordict import TensorDict
from torch import Tensor

from dr_lab.algorithms.algorithm import Algorithm, Interface
from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes, whole_episodes
from dr_lab.collectors.collector import Policy
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.first_episodes import first_episodes
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.seeding import derived_seed, stream


class EpisodicAlgorithm(Algorithm):
    """Learns from A_t = Σ_s (γλ)^(s−t) (r_s + γ b_{s+1} − b_s), which is G_t − b_t where λ = 1.

    An iteration draws a context for each slot from p(z) and plays one whole episode in it; what a slot plays after its
    first episode is not learnt from. Episodes in infeasible contexts are not learnt from either.

    Args:
        interface: what the policy is connected to.
        seed: of the network, actions and contexts.
        actor: makes the policy, from observation width, bounds and seed; without hidden layers it is linear.
        baseline: gives b_t.
        slots: k, episodes side by side.
        batch_frames: control steps that are collected at once until every slot has ended an episode.
        gamma: discount per control step.
        lam: λ.
    """

    def __init__(
        self,
        interface: Interface,
        seed: int,
        actor: Callable[..., GaussianActor],
        baseline: Baseline,
        slots: int,
        batch_frames: int,
        gamma: float,
        lam: float,
    ) -> None:
        self.baseline, self.slots, self.batch_frames = baseline, slots, batch_frames
        self.gamma, self.lam = gamma, lam
        bounds = (interface.low, interface.high)
        self.actor = actor(interface.observation, *bounds, derived_seed(seed, "actor")).to(interface.device)
        baseline.begin(interface.device)
        self.rng = stream(seed, type(self).__name__.lower())

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
        figures = self._learn(episodes) if len(episodes.reward) else {}
        self.actor.normaliser.update(cast(Tensor, batch["observation"])[first])
        return {"episodes_learnt": float(len(episodes.reward)), **figures}

    def _learn(self, episodes: WholeEpisodes) -> Mapping[str, float]:
        to_go = episodes.returns_to_go(self.gamma)
        baseline = self.baseline(episodes, to_go)
        figures = self._step(episodes, episodes.advantages(baseline, self.gamma, self.lam))
        lived = episodes.mask > 0
        return {
            **figures,
            "explained": 1.0 - ((to_go - baseline)[lived].var() / to_go[lived].var()).item(),
            "std": self.actor.log_std.exp().mean().item(),
            **self.baseline.learn(episodes, to_go),
        }

    @abstractmethod
    def _step(self, episodes: WholeEpisodes, advantage: Tensor) -> Mapping[str, float]:
        """Move the policy along its advantages (k, t); gives figures to be recorded, by name."""

    def explore_anew(self, seed: int) -> None:
        """Draw actions and contexts by other random numbers; the baseline learns by others."""
        super().explore_anew(seed)
        self.baseline.explore_anew(seed)
        self.rng = stream(seed, "explore_anew", type(self).__name__.lower())

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "actor": self.actor.state_dict(),
            "baseline": self.baseline.state_dict(),
            "rng": self.rng.bit_generator.state,
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.actor.load_state_dict(state["actor"])
        self.baseline.load_state_dict(state.get("baseline", {}))  # earlier versions kept none
        self.rng.bit_generator.state = state["rng"]
