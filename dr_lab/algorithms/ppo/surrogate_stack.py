"""PPO's loss for many policies at once."""

import copy
from collections.abc import Sequence

import torch

from dr_lab.algorithms.ppo.explicit_surrogate import ExplicitSurrogate
from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate, Terms
from dr_lab.networks.restack import restack


class SurrogateStack:
    """Differentiates N losses, each by its own actor and critic, with one pass through stacked networks.

    Args:
        surrogates: N losses, made alike.

    Attributes:
        together: the loss of the stack, on samples (N, b, …).
    """

    def __init__(self, surrogates: Sequence[Surrogate]) -> None:
        self._surrogates, like = surrogates, surrogates[0]
        actor, critic = copy.deepcopy(like.actor), copy.deepcopy(like.critic)
        restack(actor, [each.actor for each in surrogates])
        restack(critic, [each.critic for each in surrogates])
        self.together = ExplicitSurrogate(actor, critic, like.clip, like.entropy_weight, like.critic_weight)
        every = [(each.actor_parameters, each.critic_parameters) for each in surrogates]
        whole = (self.together.actor_parameters, self.together.critic_parameters)
        self._kinds = list(zip(zip(*every, strict=True), whole, strict=True))

    def differentiate(self, samples: Sequence[PolicySamples]) -> Terms:
        """The losses, shape (N,) each; their gradients are in the parameters of each surrogate afterwards.

        Args:
            samples: a minibatch for each policy, all of one size.
        """
        for each, whole in self._kinds:
            torch.stack([one.vector for one in each], out=whole.vector)
        terms = self._differentiate(PolicySamples(*(torch.stack(field) for field in zip(*samples, strict=True))))
        for each, whole in self._kinds:
            for one, gradient in zip(each, whole.gradient, strict=True):
                one.gradient.copy_(gradient)
        return terms

    def _differentiate(self, samples: PolicySamples) -> Terms:
        """The losses of the stack, on samples (N, b, …)."""
        return self.together.differentiate(samples)
