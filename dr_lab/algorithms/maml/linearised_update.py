"""Policies of many tasks, and their updates, in the vicinity of their parameters."""

from collections.abc import Mapping

import torch
from torch import Tensor, vmap

from dr_lab.algorithms.maml.inner_loss import InnerLoss
from dr_lab.algorithms.trpo.policy_rows import PolicyRows
from dr_lab.networks.gaussian import Gaussian
from dr_lab.networks.gaussian_actor import GaussianActor
from dr_lab.networks.linearised_mlp import LinearisedMLP

_BODY = "body."


class LinearisedPolicy:
    """T policies, y = (μ, log σ) each, in rows of their own; no graph leads anywhere.

    Parameters, gradients and directions have a leading dimension of T.

    Args:
        actor: the architecture.
        parameters: θ_i by name.
        observation: normalised, shape (T, R, o).
    """

    def __init__(self, actor: GaussianActor, parameters: Mapping[str, Tensor], observation: Tensor) -> None:
        self.network = LinearisedMLP(actor.body, _of_body(parameters), observation)
        self.policy = Gaussian(self.network.output, parameters["log_std"].unsqueeze(1))

    def pushed(self, direction: Mapping[str, Tensor]) -> Gaussian:
        """How y changes along a direction of the parameters."""
        return Gaussian(self.network.tangents(_of_body(direction))[-1], direction["log_std"].unsqueeze(1))

    def pulled(self, slope: Gaussian) -> dict[str, Tensor]:
        """How a scalar changes with the parameters, from how it does with y."""
        return _named(self.network.gradient(self.network.slopes(slope.mean)), slope.log_std)


class LinearisedUpdate:
    """Gradient g and Hessian H of an inner loss in T tasks.

    Args:
        actor: the architecture.
        loss: of one task.
        parameters: θ_i by name.
        rows: of T tasks.

    Attributes:
        gradient: g by the name of the parameter.
    """

    def __init__(
        self, actor: GaussianActor, loss: InnerLoss, parameters: Mapping[str, Tensor], rows: PolicyRows
    ) -> None:
        near = LinearisedPolicy(actor, parameters, rows.observation)
        self._network = near.network
        self._outputs = [output.detach().clone().requires_grad_() for output in near.policy]
        with torch.enable_grad():
            total = vmap(loss)(Gaussian(*self._outputs), rows).sum()
            self._slope = torch.autograd.grad(total, self._outputs, create_graph=True, materialize_grads=True)
        mean, log_std = (part.detach() for part in self._slope)
        self._slopes = self._network.slopes(mean)
        self.gradient = _named(self._network.gradient(self._slopes), log_std)

    def curved(self, direction: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """H u, for a direction u of the parameters of each task."""
        body = _of_body(direction)
        tangents = self._network.tangents(body)
        along = (tangents[-1], direction["log_std"].unsqueeze(1))
        with torch.enable_grad():
            change = sum((a * b).sum() for a, b in zip(self._slope, along, strict=True))
        assert isinstance(change, Tensor)
        mean, log_std = torch.autograd.grad(change, self._outputs, retain_graph=True, materialize_grads=True)
        return _named(self._network.gradient_along(self._slopes, body, tangents, mean), log_std)


def _of_body(parameters: Mapping[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(_BODY): value for name, value in parameters.items() if name.startswith(_BODY)}


def _named(body: Mapping[str, Tensor], log_std: Tensor) -> dict[str, Tensor]:
    return {"log_std": log_std.squeeze(1), **{_BODY + name: value for name, value in body.items()}}
