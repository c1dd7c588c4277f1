"""What an adaptation descends: REINFORCE's loss, or PPO's."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

from torch import Tensor

from dr_lab.algorithms.ppo.clipped import clipped
from dr_lab.algorithms.trpo.policy_rows import PolicyRows, mean, ratio
from dr_lab.bounds import Positive, require_bounds
from dr_lab.networks.gaussian import Gaussian


class InnerLoss(ABC):
    """A loss of one task, pure, which `torch.func` can differentiate twice."""

    @abstractmethod
    def __call__(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        """The loss, a scalar.

        Args:
            policy: in the rows, μ of shape (R, nu).
            rows: what the policy that acted in the task led to.
        """


@dataclass(frozen=True)
class ScoreLoss(InnerLoss):
    """−E[log π(u|o) A], whose gradient is REINFORCE's (Williams 1992; Finn et al. 2017)."""

    def __call__(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        """The loss."""
        return -mean(policy.log_prob(rows.action) * rows.advantage, rows)


@dataclass(frozen=True)
class ClippedLoss(InnerLoss):
    """−E[min(ρA, clip(ρ, 1 ± ε)A)]; at the policy that acted its gradient is REINFORCE's, its Hessian is another.

    Source: Schulman et al. 2017; as an inner loss, Rothfuss et al. 2019.

    Attributes:
        clip: ε.

    Raises:
        ConfigError: it is not above 0.
    """

    clip: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "algorithm.adaptation.loss")

    def __call__(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        """The loss."""
        return -mean(clipped(ratio(policy, rows), rows.advantage, self.clip), rows)
