"""What tells an expert's control steps from those of the policy that imitates it."""

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from tensordict import TensorDict
from tensordict.nn import TensorDictModule
from torch import Tensor, nn
from torch.nn.functional import softplus
from torchrl.objectives import GAILLoss

from dr_lab.algorithms.algorithm import CPU
from dr_lab.bounds import Count, NotNegative, Positive, require_bounds
from dr_lab.experts.expert import Demonstrations
from dr_lab.networks.mlp import MLP
from dr_lab.networks.normaliser import RunningNormaliser
from dr_lab.seeding import derived_seed


class Belief(nn.Module):
    """D(o, a), the probability that a control step is one of the expert's.

    Args:
        observation: width o.
        action: width nu, of actions scaled to ±1.
        seed: of the weights.
        hidden: widths of the hidden layers, with tanh between them.
        clip: largest absolute value of an observation, in standard deviations.
    """

    def __init__(self, observation: int, action: int, seed: int, hidden: Sequence[int], clip: float) -> None:
        super().__init__()
        self.normaliser = RunningNormaliser(observation, clip)
        generator = torch.Generator().manual_seed(seed)
        self.body = MLP(observation + action, hidden, 1, "tanh", last_gain=0.1, generator=generator)  # no opinion first

    def logit(self, observation: Tensor, action: Tensor) -> Tensor:
        """Log D/(1 − D), shape (…, 1)."""
        return self.body(torch.cat([self.normaliser(observation), action], -1))

    def forward(self, observation: Tensor, action: Tensor) -> Tensor:
        """D, shape (…, 1)."""
        return self.logit(observation, action).sigmoid()


class ImitationDiscriminator:
    """Learns D with TorchRL's `GAILLoss`, and rewards what it takes for the expert's.

    Descends L = −E_expert[log D] − E_policy[log(1 − D)] + λ E[(‖∇D‖ − 1)²], the last at points between both sides.

    Source: Ho and Ermon 2016, with D and 1 − D exchanged; the penalty is that of Gulrajani et al. 2017.

    Args:
        observation: width o.
        action: width nu.
        seed: of weights, minibatches and the points of the penalty.
        hidden: widths of the hidden layers.
        learning_rate: of Adam.
        minibatch: control steps of each side.
        epochs: minibatches of an update hold its control steps so many times.
        gradient_penalty: λ.
        clip: largest absolute value of an observation, in standard deviations.
        device: where it learns, and the control steps are.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        observation: int,
        action: int,
        seed: int,
        hidden: Sequence[int],
        learning_rate: Positive,
        minibatch: Count,
        epochs: Positive,
        gradient_penalty: NotNegative,
        clip: Positive,
        device: torch.device = CPU,
    ) -> None:
        self.learning_rate, self.minibatch, self.epochs = learning_rate, minibatch, epochs
        self.gradient_penalty, self.clip = gradient_penalty, clip
        require_bounds(self, "algorithm.discriminator", ImitationDiscriminator)
        self.belief = Belief(observation, action, seed, hidden, clip).to(device)
        network = TensorDictModule(self.belief, in_keys=["observation", "action"], out_keys=["d_logits"])
        self._loss = GAILLoss(network, use_grad_penalty=gradient_penalty > 0.0, gp_lambda=gradient_penalty)
        self._adam = torch.optim.Adam(self._loss.parameters(), lr=learning_rate)
        self._device = device
        self._generator = torch.Generator().manual_seed(seed)

    @torch.no_grad()
    def reward(self, observation: Tensor, action: Tensor) -> Tensor:
        """−log(1 − D) of control steps (…, o) and (…, nu), shape (…, 1); never negative."""
        return softplus(self.belief.logit(observation, action))

    @torch.no_grad()
    def accuracy(self, expert: Demonstrations, observation: Tensor, action: Tensor) -> float:
        """Share that is told right, the mean of both sides' shares: ½ where they cannot be told apart."""
        theirs = self.belief.logit(expert.observation, expert.action) > 0
        ours = self.belief.logit(observation, action) <= 0
        return (float(theirs.double().mean()) + float(ours.double().mean())) / 2

    def learn(self, expert: Demonstrations, observation: Tensor, action: Tensor) -> float:
        """Learn from control steps of the policy, (k, o) and (k, nu), beside the expert's; gives the mean loss.

        Args:
            expert: actions scaled to ±1.
            observation: of the policy's steps.
            action: of the policy's steps, scaled to ±1.
        """
        as_many = self._drawn(len(expert.observation), len(observation))
        self.belief.normaliser.update(torch.cat([expert.observation[as_many], observation]))
        count = max(1, round(self.epochs * len(observation) / self.minibatch))
        with torch.random.fork_rng():  # the loss draws the points of the penalty from torch's own stream
            torch.manual_seed(int(torch.randint(2**31, (), generator=self._generator)))
            losses = [self._step(expert, observation, action) for _ in range(count)]
        return sum(losses) / count

    def _step(self, expert: Demonstrations, observation: Tensor, action: Tensor) -> float:
        theirs, ours = (self._drawn(len(side), self.minibatch) for side in (expert.observation, observation))
        sides = {
            "observation": expert.observation[theirs],
            "action": expert.action[theirs],
            "collector_observation": observation[ours],
            "collector_action": action[ours],
        }
        loss = self._loss(TensorDict(sides, batch_size=[self.minibatch]))["loss"]
        self._adam.zero_grad()
        loss.backward()
        self._adam.step()
        return loss.item()

    def _drawn(self, rows: int, count: int) -> Tensor:
        """So many of some rows, one as likely as another."""
        return torch.randint(rows, (count,), generator=self._generator).to(self._device)

    def explore_anew(self, seed: int) -> None:
        """Learn from other minibatches."""
        self._generator.manual_seed(derived_seed(seed, "explore_anew", "discriminator"))

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "belief": self.belief.state_dict(),
            "adam": self._adam.state_dict(),
            "generator": self._generator.get_state(),
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.belief.load_state_dict(state["belief"])
        self._adam.load_state_dict(state["adam"])
        self._generator.set_state(state["generator"])
