"""The contract of what moves parameters by the rows that they have led to."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Protocol

import torch
from torch import Tensor

from dr_lab.algorithms.trpo.policy_rows import PolicyRows
from dr_lab.networks.flat import FlatParameters
from dr_lab.networks.gaussian import Gaussian


class Linearised(Protocol):
    """A policy in some rows, y = (μ, log σ), in the vicinity of its parameters: y(θ + v) ≈ y + J v."""

    @property
    def policy(self) -> Gaussian:
        """Y itself, without a graph."""
        ...

    def pushed(self, direction: Tensor) -> Gaussian:
        """J v for v of shape (p,), in the shapes of y."""
        ...

    def pulled(self, slope: Gaussian) -> Tensor:
        """Jᵀ s for s in the shapes of y, shape (p,)."""
        ...


class PolicyAt(Protocol):
    """What acts in some rows, as a function of parameters (p,)."""

    def __call__(self, vector: Tensor) -> Gaussian:
        """The policy, μ of shape (…, R, nu)."""
        ...

    def linearised(self, vector: Tensor) -> Linearised:
        """The same in the vicinity of the parameters."""
        ...

    def thinned(self, every: int) -> "PolicyAt":
        """The same by and in fewer rows, those that `PolicyRows.thinned` keeps."""
        ...


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

    def differentiate(self, near: Linearised, rows: PolicyRows) -> tuple[float, Tensor]:
        """The loss of a policy, and its gradient, shape (p,)."""
        outputs = Gaussian(*(part.detach().requires_grad_() for part in near.policy))
        with torch.enable_grad():
            loss = self.loss(outputs, rows)
        return loss.item(), near.pulled(Gaussian(*torch.autograd.grad(loss, list(outputs))))

    def state_dict(self) -> dict[str, Any]:
        """All that the next step depends on besides the parameters."""
        return {}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:  # noqa: B027 (some keep nothing)
        """Continue from what `state_dict` gave."""
