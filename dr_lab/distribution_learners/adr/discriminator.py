"""What tells transitions of randomised contexts from those of the reference."""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits, logsigmoid

from dr_lab.bounds import Limit, NotNegative, Positive, at_least, require_bounds
from dr_lab.networks.adam import Adam
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.mlp import MLP
from dr_lab.networks.normaliser import RunningNormaliser

_FIRST = 0.1  # gain of the last layer: no opinion to begin with
_EPSILON = 1e-8  # of Adam, as torch has it


class Discriminator:
    """D(s, a, s′), the probability that a transition is one of a randomised context, where either side is as likely.

    Descends, with minibatches of which one half is drawn from either side,

        L = −½ E_randomised[log D] − ½ E_reference[log(1 − D)].

    Its inputs are normalised by the mean and standard deviation of all transitions seen so far, both sides together.

    Args:
        size: width of a transition.
        seed: of weights and minibatches.
        hidden: widths of the hidden layers, with tanh between them.
        learning_rate: of Adam.
        minibatch: transitions, both sides together.
        epochs: minibatches of a round hold its randomised transitions so many times; 0 leaves D as it is (frozen).
        clip: largest absolute value of an input, in standard deviations.

    Raises:
        ConfigError: a number is out of its range.
    """

    def __init__(
        self,
        size: int,
        seed: int,
        hidden: Sequence[int],
        learning_rate: Positive,
        minibatch: Annotated[int, at_least(2)],
        epochs: NotNegative,
        clip: Limit,
    ) -> None:
        self.size, self.learning_rate, self.minibatch, self.epochs = size, learning_rate, minibatch, epochs
        self.clip = clip
        require_bounds(self, "distribution_learner.discriminator", Discriminator)
        self._generator = torch.Generator().manual_seed(seed)
        self._normaliser = RunningNormaliser(size, clip)
        self._body = MLP(size, hidden, 1, "tanh", _FIRST, self._generator)
        self._flat = FlatParameters(self._body.parameters())
        self._adam = Adam(self._flat, _EPSILON)

    @torch.no_grad()
    def log_ratio(self, transitions: Tensor) -> Tensor:
        """Log D − log ½ of transitions (…, size), shape (…): above 0 where they seem to be of a randomised context."""
        return logsigmoid(self._body(self._normaliser(transitions)).squeeze(-1)) + math.log(2.0)

    def accuracy(self, randomised: Tensor, reference: Tensor) -> float:
        """Share that is told right, the mean of both sides' shares: ½ where they cannot be told apart."""
        right = [(self.log_ratio(randomised) > 0).double().mean(), (self.log_ratio(reference) <= 0).double().mean()]
        return float(sum(right)) / 2

    def adapt(self, transitions: Tensor) -> None:
        """Take transitions of both sides into the statistics of the inputs, unless D is frozen."""
        if self.epochs:
            self._normaliser.update(transitions)

    @torch.no_grad()
    def learn(self, randomised: Tensor, reference: Tensor) -> float:
        """Learn from transitions of both sides, (k, size) and (l, size); gives the mean loss, NaN where D is frozen."""
        half = self.minibatch // 2
        sides = [self._normaliser(side) for side in (randomised, reference)]
        targets = torch.cat([torch.ones(half), torch.zeros(half)])
        losses = [self._step(self._drawn(sides, half), targets) for _ in range(self._count(len(randomised), half))]
        return sum(losses) / len(losses) if losses else math.nan

    def state_dict(self) -> dict[str, Any]:
        """All that an exact continuation needs."""
        return {
            "size": self.size,
            "vector": self._flat.vector.clone(),
            "adam": self._adam.state_dict(),
            "normaliser": self._normaliser.state_dict(),
            "generator": self._generator.get_state(),
        }

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Continue from what `state_dict` gave."""
        self.inherit(state)
        self._adam.load_state_dict(state["adam"])
        self._generator.set_state(state["generator"])

    def inherit(self, state: Mapping[str, Any]) -> None:
        """Take over what another one has learnt."""
        self._flat.vector.copy_(state["vector"])
        self._normaliser.load_state_dict(state["normaliser"])

    def _count(self, randomised: int, half: int) -> int:
        return math.ceil(self.epochs * randomised / half)

    def _drawn(self, sides: Sequence[Tensor], half: int) -> Tensor:
        rows = [side[torch.randint(len(side), (half,), generator=self._generator)] for side in sides]
        return torch.cat(rows)

    def _step(self, inputs: Tensor, targets: Tensor) -> float:
        layers = self._body.layers(inputs)
        logits = layers[-1].squeeze(-1)
        slope = (logits.sigmoid() - targets) / len(targets)
        self._body.backward(layers, slope[:, None], *self._flat.gradients_of(self._body))
        self._adam.step(self.learning_rate)
        return float(binary_cross_entropy_with_logits(logits, targets))
