"""PPO's loss of many policies that keep near each other."""

from collections.abc import Sequence

import torch
from torch import Tensor

from dr_lab.algorithms.ppo.surrogate import PolicySamples, Surrogate, Terms
from dr_lab.algorithms.ppo.surrogate_stack import SurrogateStack
from dr_lab.bounds import NotNegative, require_bounds
from dr_lab.networks.gaussian import Gaussian, divergence


class PeerSurrogate(SurrogateStack):
    """As `SurrogateStack`, and L_i += α/(N − 1) Σ_{j ≠ i} E[KL(π_i ‖ π_j)] in the states of policy i.

    The peers π_j are as they are at this step, and nothing is followed back through them.

    Source: Zhao and Hospedales 2021, whose term this is; α as Brosseit et al. 2021, table I, call it.

    Args:
        surrogates: N losses, made alike, of actors with one normaliser.
        alpha: α.

    Raises:
        ConfigError: α is negative.
    """

    def __init__(self, surrogates: Sequence[Surrogate], alpha: NotNegative) -> None:
        super().__init__(surrogates)
        self.alpha, self._count = alpha, len(surrogates)
        require_bounds(self, "algorithm", PeerSurrogate)

    def _differentiate(self, samples: PolicySamples) -> Terms:
        parameters = self.together.actor_parameters
        terms = super()._differentiate(samples)
        own = parameters.gradient.clone()
        apart = self.divergences(samples.observation)
        parameters.differentiate(self.alpha * apart.sum())
        parameters.gradient.add_(own)
        return terms._replace(objective=terms.objective + self.alpha * apart.detach())

    def divergences(self, observation: Tensor) -> Tensor:
        """Mean of KL(π_i ‖ π_j) over the peers of each policy and its states (N, b, o), shape (N,)."""
        body, log_std = self.together.actor.body, self.together.actor.log_std  # log_std: (N, 1, nu)
        one = Gaussian(body(observation), log_std)
        with torch.no_grad():
            every = body(observation.flatten(0, 1).expand(self._count, -1, -1))
            peers = Gaussian(every.unflatten(1, (self._count, -1)), log_std.unsqueeze(1))
        return divergence(one, peers).mean(-1).sum(0) / max(self._count - 1, 1)  # that to itself is 0
