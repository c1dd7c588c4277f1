"""A policy as a function of its own parameters, which autograd linearises."""

from collections.abc import Mapping

import torch
from torch import Tensor
from torch.autograd import grad

from dr_lab.networks.flat import parts_of
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor


class OwnPolicy:
    """What a policy does in some rows; fulfils `PolicyAt`.

    Args:
        actor: the policy.
        like: its parameters, in the order of the vector.
        observation: of the rows, normalised, shape (R, o).
    """

    def __init__(self, actor: GaussianActor, like: Mapping[str, Tensor], observation: Tensor) -> None:
        self._actor, self._like, self._observation = actor, like, observation

    def __call__(self, vector: Tensor) -> Gaussian:
        """The policy, μ of shape (R, nu), log σ of shape (1, nu)."""
        policy = self._actor.distribution(parts_of(vector, self._like), self._observation)
        return Gaussian(policy.mean, policy.log_std.unsqueeze(0))

    def linearised(self, vector: Tensor) -> "AutogradLinearised":
        """The same in the vicinity of the parameters."""
        at = vector.detach().clone().requires_grad_()
        with torch.enable_grad():
            return AutogradLinearised(self(at), at)

    def thinned(self, every: int) -> "OwnPolicy":
        """The same in fewer rows."""
        return OwnPolicy(self._actor, self._like, self._observation[::every])


class AutogradLinearised:
    """J v and Jᵀ s of any policy that has a graph; fulfils `Linearised`.

    J v is the derivative of u ↦ Jᵀ u, which is linear: both go back through graphs that are made once.

    Args:
        policy: with a graph that leads to `at`.
        at: θ, a leaf that requires a gradient, shape (p,).
    """

    def __init__(self, policy: Gaussian, at: Tensor) -> None:
        self._outputs, self._at = policy, at
        self._probes = [torch.zeros_like(output, requires_grad=True) for output in policy]
        (self._back,) = grad(list(policy), at, self._probes, create_graph=True)

    @property
    def policy(self) -> Gaussian:
        """What acts, without a graph."""
        return Gaussian(*(output.detach() for output in self._outputs))

    def pushed(self, direction: Tensor) -> Gaussian:
        """J v."""
        return Gaussian(*grad(self._back, self._probes, direction, retain_graph=True))

    def pulled(self, slope: Gaussian) -> Tensor:
        """Jᵀ s."""
        (found,) = grad(list(self._outputs), self._at, list(slope), retain_graph=True)
        return found
