"""A policy that does what others would do on average."""

from typing import Any

from torch import Tensor, nn

from dr_lab.networks.policy_stack import PolicyStack


class MeanPolicy(nn.Module):
    """a = (1/N) Σ_k μ_k(o), without noise; N networks are asked at every step.

    Args:
        policies: N of them.
    """

    def __init__(self, policies: PolicyStack) -> None:
        super().__init__()
        self.stack = policies

    def forward(self, observation: Tensor) -> Tensor:
        """The action (n, nu) for observations (n, o)."""
        count = len(self.stack.policies)
        return self.stack.mean(observation.repeat(count, 1)).unflatten(0, (count, -1)).mean(0)

    def load_state_dict(self, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 (torch's signature)
        """As torch's, and act so."""
        loaded = super().load_state_dict(*args, **kwargs)
        self.stack.refresh()
        return loaded
