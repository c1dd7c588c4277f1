"""Learning rates of an adaptation: one that is given, or one for each parameter that is learnt."""

from abc import ABC, abstractmethod
from collections.abc import Mapping

import torch
from torch import Tensor, nn

from dr_lab.bounds import Positive, require_bounds
from dr_lab.networks.flat import parts_of
from dr_lab.networks.gaussian_actor import GaussianActor


class InnerRate(nn.Module, ABC):
    """α of every parameter of a policy; what is learnt of it are this module's parameters."""

    @abstractmethod
    def of(self, own: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
        """α by the name of the policy's parameter, in a shape that broadcasts to it; linear in what is learnt, if any.

        Args:
            own: parameters in place of this module's own, as ``dict(rate.named_parameters())`` names them.
        """


class FixedRate(InnerRate):
    """The same α for all.

    Args:
        actor: the policy.
        rate: α.

    Raises:
        ConfigError: it is not above 0.
    """

    def __init__(self, actor: GaussianActor, rate: Positive) -> None:
        super().__init__()
        self.rate = rate
        require_bounds(self, "algorithm.adaptation.rate", FixedRate)
        alpha = torch.tensor(float(rate), dtype=torch.float64, device=actor.log_std.device)  # takes any's type
        self._rates = dict.fromkeys(dict(actor.named_parameters()), alpha)

    def of(self, own: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
        """The number."""
        del own
        return self._rates


class LearnedRate(InnerRate):
    """One for each parameter, learnt with the policy, of either sign (Meta-SGD, Li et al. 2017).

    Args:
        actor: the policy.
        rate: α of all to begin with.

    Raises:
        ConfigError: it is not above 0.
    """

    def __init__(self, actor: GaussianActor, rate: Positive) -> None:
        super().__init__()
        self.rate = rate
        require_bounds(self, "algorithm.adaptation.rate", LearnedRate)
        self._like = {name: value.detach() for name, value in actor.named_parameters()}
        size = sum(value.numel() for value in self._like.values())
        self.rates = nn.Parameter(torch.full((size,), float(rate), device=actor.log_std.device))

    def of(self, own: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
        """The parts of the vector."""
        return parts_of(own["rates"], self._like)
