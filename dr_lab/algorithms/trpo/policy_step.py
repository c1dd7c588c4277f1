"""The contract of what moves parameters by the rows that they have led to."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

from torch import Tensor

from dr_lab.algorithms.trpo.policy_rows import PolicyRows
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian import Gaussian

PolicyAt = Callable[[Tensor], Gaussian]
"""What acts in some rows, μ of shape (…, R, nu), as a function of parameters (p,); pure, and twice differentiable."""


class PolicyStep(ABC):
    """Moves θ, from which the policy that acts follows in whatever way, against the gradient of `loss`.

    Args:
        parameters: θ.
    """

    def __init__(self, parameters: FlatParameters) -> None:
        self.parameters = parameters

    @abstractmethod
    def loss(self, policy: Gaussian, rows: PolicyRows) -> Tensor:
        """What is descended, at another policy than the one that acted; a scalar."""

    @abstractmethod
    def __call__(self, policy_at: PolicyAt, rows: PolicyRows) -> Mapping[str, float]:
        """Move `parameters.vector`; gives figures to be recorded, by name.

        Args:
            policy_at: at the present parameters it is the policy that acted.
            rows: what it led to.
        """

    def state_dict(self) -> dict[str, Any]:
        """All that the next step depends on besides the parameters."""
        return {}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:  # noqa: B027 (some keep nothing)
        """Continue from what `state_dict` gave."""
