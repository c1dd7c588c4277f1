"""A value network that learns the returns-to-go from batch to batch."""

from collections.abc import Callable, Mapping
from typing import Any

import torch
from torch import Tensor

from dr_lab.algorithms.algorithm import CPU
from dr_lab.algorithms.reinforce.baseline import Baseline
from dr_lab.algorithms.reinforce.whole_episodes import WholeEpisodes
from dr_lab.bounds import Count, NotNegative, Positive, require_bounds
from dr_lab.networks.adam import Adam
from dr_lab.networks.critic import Critic
from dr_lab.networks.flat import FlatParameters
from dr_lab.seeding import derived_seed


class CriticBaseline(Baseline):
    """b = m + s·V(o), where V descends mean (V − (G − m)/s)² and m, s are mean and spread of the first batch's G.

    It is 0 until it has learnt. The network is made when the width of an observation is known.

    Args:
        critic: makes V, from the width of an observation and a seed.
        seed: of its weights and of the order of samples.
        epochs: passes over a batch.
        minibatch: samples in a step.
        rate: learning rate of Adam.
        adam_epsilon: ε of Adam.

    Raises:
        ConfigError: a number is out of its range.
    """

    learns = True

    def __init__(
        self,
        critic: Callable[[int, int], Critic],
        seed: int,
        epochs: Count,
        minibatch: Count,
        rate: Positive,
        adam_epsilon: NotNegative,
    ) -> None:
        self.epochs, self.minibatch, self.rate, self.adam_epsilon = epochs, minibatch, rate, adam_epsilon
        require_bounds(self, "algorithm.baseline", CriticBaseline)
        self._make, self._seed = critic, seed
        self._generator = torch.Generator().manual_seed(seed)
        self._learner: _Learner | None = None
        self._device = CPU

    def begin(self, device: torch.device) -> None:
        """Make the network there."""
        self._device = device

    def __call__(self, episodes: WholeEpisodes, to_go: Tensor) -> Tensor:
        """The value of every step's observation."""
        learner = self._learner
        if learner is None:
            return torch.zeros_like(to_go)
        return learner.shift + learner.scale * learner.critic(episodes.observation)

    def learn(self, episodes: WholeEpisodes, to_go: Tensor) -> Mapping[str, float]:
        """Some epochs of minibatches on the steps of a batch; gives the mean loss."""
        lived = episodes.mask > 0
        observation, wanted = episodes.observation[lived], to_go[lived]
        learner = self._made(observation.shape[-1], wanted)
        wanted, losses = (wanted - learner.shift) / learner.scale, list[Tensor]()
        for _ in range(self.epochs):
            order = torch.randperm(len(wanted), generator=self._generator).to(self._device)
            losses += [self._step(learner, observation[rows], wanted[rows]) for rows in order.split(self.minibatch)]
        return {"critic_loss": float(torch.stack(losses).mean())} if losses else {}

    def explore_anew(self, seed: int) -> None:
        """Take the samples in another order."""
        self._generator.manual_seed(derived_seed(seed, "explore_anew", "baseline"))

    def state_dict(self) -> dict[str, Any]:
        """Network, optimiser and random numbers."""
        learner = self._learner
        kept = None
        if learner is not None:
            scales = {"shift": learner.shift.clone(), "scale": learner.scale.clone()}
            kept = {"size": learner.size, "vector": learner.flat.vector.clone(), "adam": learner.adam.state_dict()}
            kept |= scales
        return {"generator": self._generator.get_state(), "learner": kept}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self._generator.set_state(state["generator"])
        kept, self._learner = state["learner"], None
        if kept is not None:
            learner = self._made(kept["size"], torch.zeros(0, device=self._device))
            learner.flat.vector.copy_(kept["vector"])
            learner.adam.load_state_dict(kept["adam"])
            learner.shift, learner.scale = (kept[name].clone().to(self._device) for name in ("shift", "scale"))

    def _made(self, size: int, wanted: Tensor) -> "_Learner":
        if self._learner is None:
            self._learner = _Learner(self._make(size, self._seed).to(self._device), size, wanted, self.adam_epsilon)
        return self._learner

    def _step(self, learner: "_Learner", observation: Tensor, wanted: Tensor) -> Tensor:
        loss = (learner.critic(observation) - wanted).square().mean()
        learner.flat.differentiate(loss)
        learner.adam.step(self.rate)
        return loss.detach()


class _Learner:
    """A network, its optimiser, and the unit of what it learns."""

    def __init__(self, critic: Critic, size: int, wanted: Tensor, adam_epsilon: float) -> None:
        self.critic, self.size = critic, size
        self.flat = FlatParameters(critic.parameters())
        self.adam = Adam(self.flat, adam_epsilon)
        known = len(wanted) > 1
        self.shift = wanted.mean() if known else wanted.new_zeros(())
        self.scale = wanted.std().clamp(min=1e-6) if known else wanted.new_ones(())  # 1e-6: returns that are all alike
